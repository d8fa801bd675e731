#include "configuration_options.h"

#include "ring_gyro/configuration/configuration_reader.h"

namespace ring_gyro {

namespace options = boost::program_options;

void ConfigurationOptions::addTo(options::options_description& description) {
  description.add_options()("config,c", options::value(&file_), "YAML file of the configuration")(
      "seed", options::value(&seed_), "of all noise, instead of run/seed")(
      "set", options::value(&overrides_)->composing(),
      "section/key=value, in place of what the file says; may be repeated");
}

LoopConfiguration ConfigurationOptions::read() const {
  if (file_.empty()) throw options::error("--config FILE is missing; see --help");
  std::vector<std::string> overrides = overrides_;
  if (!seed_.empty()) overrides.push_back("run/seed=" + seed_);
  return readConfigurationFile(file_, overrides);
}

}  // namespace ring_gyro
