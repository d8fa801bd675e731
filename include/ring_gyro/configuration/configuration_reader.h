#pragma once

#include <yaml-cpp/yaml.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "ring_gyro/common/parameter_table.h"
#include "ring_gyro/configuration/node_parameters.h"
#include "ring_gyro/simulation/loop_configuration.h"

namespace cvg {

/// All faults of a configuration, not only the first.
class ConfigurationError : public std::runtime_error {
 public:
  explicit ConfigurationError(std::vector<std::string> faults);

  /// One line per fault: key, value, allowed values. what() gives these lines.
  const std::vector<std::string>& faults() const { return faults_; }

 private:
  std::vector<std::string> faults_;
};

/// Sets the targets of the tables from a map of sections, each a map of values.
///
/// A missing key keeps its default unless it is required. Any text that is a finite number counts
/// as a number, with or without quotes, because a parameter server turns 1e-2 into text. Throws
/// ConfigurationError when a required key is missing, a key or section is unknown or given twice,
/// or a value has the wrong type, is not finite, is out of range or is not one of the choices. The
/// targets are then unspecified.
void readSections(const YAML::Node& root, const Sections& sections);

/// The configuration of a loop; `device` is copied to every part that uses it. The section `node`
/// is checked and, when `node` is given, read into it. Throws ConfigurationError.
LoopConfiguration readConfiguration(const YAML::Node& root, NodeParameters* node = nullptr);

/// The same from a file, after overrides of the form "section/key=value".
/// Throws ConfigurationError, also when the file cannot be read or an override has another form.
LoopConfiguration readConfigurationFile(const std::string& path,
                                        const std::vector<std::string>& overrides = {},
                                        NodeParameters* node = nullptr);

/// The same from several files; each overrides the keys of the earlier ones, for example a preset,
/// then a calibration.
LoopConfiguration readConfigurationFiles(const std::vector<std::string>& paths,
                                         const std::vector<std::string>& overrides = {},
                                         NodeParameters* node = nullptr);

/// Reference of all parameters: a heading and a table for each section.
std::string parametersMarkdown();

}  // namespace cvg
