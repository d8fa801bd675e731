#pragma once

#include <yaml-cpp/yaml.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "ring_gyro/common/parameter_table.h"
#include "ring_gyro/configuration/node_parameters.h"
#include "ring_gyro/simulation/loop_configuration.h"

namespace cvg {

/// Everything that is wrong with a configuration, not only the first of it.
class ConfigurationError : public std::runtime_error {
 public:
  explicit ConfigurationError(std::vector<std::string> faults);

  /// One line each: key, value, what is allowed. what() is these lines.
  const std::vector<std::string>& faults() const { return faults_; }

 private:
  std::vector<std::string> faults_;
};

/// Fills what the tables point to from a map of sections, each a map of values.
///
/// A key that is missing keeps its default unless it is required. A number is any text that is
/// wholly a finite number (a parameter server turns 1e-2 into text), whatever its quotes. Throws
/// ConfigurationError: required key missing, key or section unknown or given twice, value of the
/// wrong type, not finite, out of range or none of the choices. The targets are then unspecified.
void readSections(const YAML::Node& root, const Sections& sections);

/// The configuration of a loop, with `device` handed on to those who use it. The section `node` is
/// checked and, when `node` is given, read into it. Throws ConfigurationError.
LoopConfiguration readConfiguration(const YAML::Node& root, NodeParameters* node = nullptr);

/// The same from a file, after overrides of the form "section/key=value".
/// Throws ConfigurationError, also when the file cannot be read or an override has another form.
LoopConfiguration readConfigurationFile(const std::string& path,
                                        const std::vector<std::string>& overrides = {},
                                        NodeParameters* node = nullptr);

/// The same from several files, of which each overrides the keys of those before it: a preset, then
/// a calibration.
LoopConfiguration readConfigurationFiles(const std::vector<std::string>& paths,
                                         const std::vector<std::string>& overrides = {},
                                         NodeParameters* node = nullptr);

/// Reference of all parameters: a heading and a table for each section.
std::string parametersMarkdown();

}  // namespace cvg
