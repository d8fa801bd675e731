#include "configuration_options.h"

#include <sstream>
#include <stdexcept>
#include <variant>

#include "ring_gyro/configuration/configuration_reader.h"
#include "ring_gyro/configuration/parameter_text.h"

namespace ring_gyro {

namespace options = boost::program_options;

void ConfigurationOptions::addTo(options::options_description& description) {
  description.add_options()("config,c", options::value(&files_)->composing(),
                            "YAML file of the configuration; of several, later ones override")(
      "seed", options::value(&seed_), "of all noise, instead of run/seed")(
      "set", options::value(&overrides_)->composing(),
      "section/key=value, in place of what the file says; may be repeated");
}

LoopConfiguration ConfigurationOptions::read() const {
  if (files_.empty()) throw options::error("--config FILE is missing; see --help");
  std::vector<std::string> overrides = overrides_;
  if (!seed_.empty()) overrides.push_back("run/seed=" + seed_);
  return readConfigurationFiles(files_, overrides);
}

void requireInRange(const ParameterTable& table) {
  std::string faults;
  for (const Parameter& parameter : table.parameters()) {
    double value = 0.0;
    if (const auto* const number = std::get_if<double*>(&parameter.target)) {
      value = **number;
    } else if (const auto* const whole = std::get_if<std::int64_t*>(&parameter.target)) {
      value = static_cast<double>(**whole);
    } else {
      continue;
    }
    if (parameter.range.contains(value)) continue;
    std::ostringstream fault;
    fault << (faults.empty() ? "" : "\n") << "--" << parameter.key << " = " << value
          << ": out of range; allowed: " << allowedText(parameter);
    faults += fault.str();
  }
  if (!faults.empty()) throw std::invalid_argument(faults);
}

}  // namespace ring_gyro
