#include "configuration_options.h"

#include "ring_gyro/configuration/configuration_reader.h"

namespace ring_gyro::tools {

namespace options = boost::program_options;

void ConfigurationOptions::addTo(options::options_description& description) {
  description.add_options()("config,c", options::value(&files_)->composing(),
                            "YAML file of the configuration; of several, later ones override")(
      "seed", options::value(&seed_), "of all noise, instead of run/seed")(
      "set", options::value(&overrides_)->composing(),
      "section/key=value, in place of what the file says; may be repeated");
}

cvg::LoopConfiguration ConfigurationOptions::read(
    const std::vector<std::string>& more_overrides) const {
  if (files_.empty()) throw options::error("--config FILE is missing; see --help");
  std::vector<std::string> overrides = overrides_;
  overrides.insert(overrides.end(), more_overrides.begin(), more_overrides.end());
  if (!seed_.empty()) overrides.push_back("run/seed=" + seed_);
  return cvg::readConfigurationFiles(files_, overrides);
}

}  // namespace ring_gyro::tools
