#include "ring_gyro/common/parameter_table.h"

#include <cmath>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace cvg {

bool Range::contains(double value) const {
  if (!std::isfinite(value)) return false;
  return value <= highest && (lowest_excluded ? value > lowest : value >= lowest);
}

std::string Range::text() const {
  std::ostringstream out;
  const bool has_lowest = std::isfinite(lowest);
  const bool has_highest = std::isfinite(highest);
  if (has_lowest && has_highest) {
    out << (lowest_excluded ? "(" : "[") << lowest << ", " << highest << "]";
  } else if (has_lowest) {
    out << (lowest_excluded ? "> " : ">= ") << lowest;
  } else if (has_highest) {
    out << "<= " << highest;
  } else {
    out << "any finite number";
  }
  return out.str();
}

ParameterTable& ParameterTable::number(std::string key, double& target, std::string unit,
                                       Range range, std::string description) {
  parameters_.push_back(
      {std::move(key), &target, std::move(unit), range, std::move(description), false});
  return *this;
}

ParameterTable& ParameterTable::requiredNumber(std::string key, double& target, std::string unit,
                                               Range range, std::string description) {
  number(std::move(key), target, std::move(unit), range, std::move(description));
  parameters_.back().required = true;
  return *this;
}

ParameterTable& ParameterTable::integer(std::string key, std::int64_t& target, Range range,
                                        std::string description) {
  parameters_.push_back({std::move(key), &target, "1", range, std::move(description), false});
  return *this;
}

ParameterTable& ParameterTable::flag(std::string key, bool& target, std::string description) {
  parameters_.push_back(
      {std::move(key), &target, "1", Range::any(), std::move(description), false});
  return *this;
}

ParameterTable& ParameterTable::text(std::string key, std::string& target,
                                     std::string description) {
  parameters_.push_back(
      {std::move(key), &target, "text", Range::any(), std::move(description), false});
  return *this;
}

ParameterTable& ParameterTable::numbers(std::string key, std::vector<double>& target,
                                        std::string unit, Range range, std::string description) {
  parameters_.push_back(
      {std::move(key), &target, std::move(unit), range, std::move(description), false});
  return *this;
}

ParameterTable& ParameterTable::add(Parameter parameter) {
  parameters_.push_back(std::move(parameter));
  return *this;
}

void requireInRange(const ParameterTable& table, const std::string& prefix) {
  std::string faults;
  const auto check = [&](const Parameter& parameter, const std::string& index, double value,
                         const std::string& kind) {
    if (parameter.range.contains(value)) return;
    std::ostringstream fault;
    fault.precision(10);
    fault << (faults.empty() ? "" : "\n") << prefix << parameter.key << index << " = " << value
          << ": out of range; allowed: " << parameter.range.text() << kind;
    faults += fault.str();
  };
  for (const Parameter& parameter : table.parameters()) {
    const std::string unit = " [" + parameter.unit + "]";
    if (const auto* const whole = std::get_if<std::int64_t*>(&parameter.target)) {
      check(parameter, "", static_cast<double>(**whole), ", whole");
    } else if (const auto* const number = std::get_if<double*>(&parameter.target)) {
      check(parameter, "", **number, unit);
    } else if (const auto* const list = std::get_if<std::vector<double>*>(&parameter.target)) {
      for (std::size_t k = 0; k < (*list)->size(); ++k) {
        check(parameter, "[" + std::to_string(k) + "]", (**list)[k], unit);
      }
    } else if (const auto* const choice = std::get_if<Parameter::Choice>(&parameter.target)) {
      if (*choice->value >= choice->names.size()) {
        faults += (faults.empty() ? "" : "\n") + prefix + parameter.key + " is none of its " +
                  std::to_string(choice->names.size()) + " choices";
      }
    }
  }
  if (!faults.empty()) throw std::invalid_argument(faults);
}

}  // namespace cvg
