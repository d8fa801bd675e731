#include "ring_gyro/ros/node_configuration.h"

#include <XmlRpcValue.h>
#include <ros/param.h>

#include <string>
#include <utility>
#include <vector>

#include "ring_gyro/common/number_text.h"
#include "ring_gyro/common/output_target.h"

namespace ring_gyro::bridge {
namespace {

YAML::Node yamlFrom(XmlRpc::XmlRpcValue& value) {
  switch (value.getType()) {
    case XmlRpc::XmlRpcValue::TypeBoolean:
      return YAML::Node(static_cast<bool&>(value) ? "true" : "false");
    case XmlRpc::XmlRpcValue::TypeInt:
      return YAML::Node(std::to_string(static_cast<int&>(value)));
    case XmlRpc::XmlRpcValue::TypeDouble:
      return YAML::Node(cvg::textFromNumber(static_cast<double&>(value)));
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

/// ROS runs nodes in a folder of its own, where a user would not look for a file.
void requireWholePaths(const cvg::NodeParameters& node) {
  std::vector<std::string> faults;
  const auto check = [&faults](const char* key, const std::string& path) {
    if (path.empty() || path[0] == '/') return;
    const bool home = path.rfind("~/", 0) == 0;
    faults.push_back(std::string(key) + " = " + path +
                     (home ? ": the shell has not replaced ~; give $HOME" + path.substr(1)
                           : ": a relative path, which a node cannot follow from where you stand; "
                             "give $PWD/" +
                                 path));
  };
  check("node/bag", node.bag);
  check("node/calibration_file", node.calibration_file);
  check("node/report", node.report);
  check("node/replay", node.replay);
  if (!faults.empty()) throw cvg::ConfigurationError(std::move(faults));
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
  configuration.loop = cvg::readConfiguration(parametersOf(private_handle), &configuration.node);
  const cvg::NodeParameters& node = configuration.node;
  configuration.loop.files = {node.configuration_file, node.calibration_read,
                              configuration.loop.plant.rotation.file};
  requireWholePaths(node);
  std::vector<std::string> inputs = configuration.loop.files;
  inputs.push_back(node.replay);
  cvg::requireApart({node.bag, node.calibration_file, node.report}, inputs);
  return configuration;
}

}  // namespace ring_gyro::bridge
