#include "ring_gyro/nodes/death.h"

#include <XmlRpcValue.h>
#include <ros/master.h>
#include <ros/network.h>
#include <ros/this_node.h>

#include <boost/asio/ip/tcp.hpp>
#include <cstdint>

namespace ring_gyro::nodes {

bool hasDied(const std::string& node) {
  XmlRpc::XmlRpcValue request, response, address;
  request[0] = ros::this_node::getName();
  request[1] = node;
  if (!ros::master::execute("lookupNode", request, response, address, false)) return false;
  std::string host;
  std::uint32_t port = 0;
  if (!ros::network::splitURI(static_cast<std::string&>(address), host, port)) return false;
  boost::asio::ip::tcp::iostream connection(host, std::to_string(port));
  return connection.error() == boost::asio::error::connection_refused;
}

}  // namespace ring_gyro::nodes
