#include "ring_gyro/ros/node_configuration.h"

#include <XmlRpcValue.h>
#include <ros/param.h>

#include <string>

#include "ring_gyro/configuration/parameter_text.h"

namespace ring_gyro {
namespace {

YAML::Node yamlFrom(XmlRpc::XmlRpcValue& value) {
  switch (value.getType()) {
    case XmlRpc::XmlRpcValue::TypeBoolean:
      return YAML::Node(static_cast<bool&>(value) ? "true" : "false");
    case XmlRpc::XmlRpcValue::TypeInt:
      return YAML::Node(std::to_string(static_cast<int&>(value)));
    case XmlRpc::XmlRpcValue::TypeDouble:
      return YAML::Node(textFromNumber(static_cast<double&>(value)));
    case XmlRpc::XmlRpcValue::TypeString:
      return YAML::Node(static_cast<std::string&>(value));
    case XmlRpc::XmlRpcValue::TypeArray: {
      YAML::Node list(YAML::NodeType::Sequence);
      for (int i = 0; i < value.size(); ++i) list.push_back(yamlFrom(value[i]));
      return list;
    }
    case XmlRpc::XmlRpcValue::TypeStruct: {
      YAML::Node map(YAML::NodeType::Map);
      for (auto& entry : value) map[entry.first] = yamlFrom(entry.second);
      return map;
    }
    default:
      return YAML::Node();
  }
}

}  // namespace

YAML::Node parametersOf(const ros::NodeHandle& private_handle) {
  XmlRpc::XmlRpcValue value;
  if (!ros::param::get(private_handle.getNamespace(), value) ||
      value.getType() != XmlRpc::XmlRpcValue::TypeStruct) {
    return YAML::Node(YAML::NodeType::Map);
  }
  YAML::Node parameters = yamlFrom(value);
  for (const char* foreign : {"diagnostic_period", "diagnostic_updater"}) {
    parameters.remove(std::string(foreign));
  }
  return parameters;
}

NodeConfiguration readNodeConfiguration(const ros::NodeHandle& private_handle) {
  NodeConfiguration configuration;
  configuration.loop = readConfiguration(parametersOf(private_handle), &configuration.node);
  return configuration;
}

}  // namespace ring_gyro
