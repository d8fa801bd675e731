#pragma once

#include <boost/program_options.hpp>
#include <string>
#include <vector>

#include "ring_gyro/simulation/loop_configuration.h"

namespace ring_gyro::tools {

/// The options for the configuration of every tool: --config FILE (may be repeated: later files
/// override), --seed N and --set section/key=value.
class ConfigurationOptions {
 public:
  void addTo(boost::program_options::options_description& description);

  /// To be called after the options have been parsed; `more_overrides` are applied before --seed.
  /// Throws ConfigurationError, or boost::program_options::error when --config is missing.
  cvg::LoopConfiguration read(const std::vector<std::string>& more_overrides = {}) const;

 private:
  std::vector<std::string> files_;
  std::string seed_;
  std::vector<std::string> overrides_;
};

}  // namespace ring_gyro::tools
