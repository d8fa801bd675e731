#pragma once

#include <boost/program_options.hpp>
#include <string>
#include <vector>

#include "ring_gyro/simulation/loop_configuration.h"

namespace ring_gyro::tools {

/// The options of tools that read bags, for values that are not in the bags: --config FILE (may be
/// repeated: later files override) or --preset NAME, and --set section/key=value.
class DeviceOptions {
 public:
  void addTo(boost::program_options::options_description& description);

  /// To be called after the options have been parsed. Throws ConfigurationError, or
  /// boost::program_options::error unless there is either a file or a preset.
  cvg::LoopConfiguration read() const;

 private:
  std::vector<std::string> files_;
  std::string preset_;
  std::vector<std::string> overrides_;
};

}  // namespace ring_gyro::tools
