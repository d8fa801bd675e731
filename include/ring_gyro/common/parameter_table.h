#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace cvg {

/// Closed interval of allowed values; `above` makes the lower end open.
struct Range {
  double lowest = -std::numeric_limits<double>::infinity();
  double highest = std::numeric_limits<double>::infinity();
  bool lowest_excluded = false;

  static constexpr Range any() { return {}; }
  static constexpr Range atLeast(double lowest) { return {lowest, kInfinity, false}; }
  static constexpr Range above(double lowest) { return {lowest, kInfinity, true}; }
  static constexpr Range between(double lowest, double highest) { return {lowest, highest, false}; }

  bool contains(double value) const;  ///< false for NaN and for infinities
  std::string text() const;           ///< as a person reads it: "[0, 1]", "> 0"

 private:
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();
};

/// One parameter: the only place that gives its name, unit, range and meaning.
/// Its default is the initialiser of the field that `target` points to.
struct Parameter {
  /// An enumeration: its value k has the name names[k], and there are no others. *choice is the
  /// present name.
  struct Choice {
    std::uint8_t* value;
    std::vector<std::string> names;
    const std::string& operator*() const { return names.at(*value); }
  };
  using Target =
      std::variant<double*, std::int64_t*, bool*, std::string*, std::vector<double>*, Choice>;

  std::string key;
  Target target;
  std::string unit;  ///< SI, "1" when dimensionless
  Range range;       ///< of numbers; of each element of a list
  std::string description;
  bool required = false;  ///< there is no default: the configuration must set it
};

/// The parameters of one section of the configuration (one struct of the core).
///
/// Each core struct declares its fields here once. The code that reads, checks and writes a
/// configuration and the code that prints the reference page use this table.
class ParameterTable {
 public:
  ParameterTable& number(std::string key, double& target, std::string unit, Range range,
                         std::string description);
  ParameterTable& requiredNumber(std::string key, double& target, std::string unit, Range range,
                                 std::string description);
  ParameterTable& integer(std::string key, std::int64_t& target, Range range,
                          std::string description);
  ParameterTable& flag(std::string key, bool& target, std::string description);
  ParameterTable& text(std::string key, std::string& target, std::string description);
  /// `Enumeration` on std::uint8_t, with values from 0 on in the order of `choices`.
  template <typename Enumeration>
  ParameterTable& choice(std::string key, Enumeration& target, std::vector<std::string> choices,
                         std::string description) {
    static_assert(std::is_same_v<std::underlying_type_t<Enumeration>, std::uint8_t>);
    return add({std::move(key),
                Parameter::Choice{reinterpret_cast<std::uint8_t*>(&target), std::move(choices)},
                "text", Range::any(), std::move(description), false});
  }
  ParameterTable& numbers(std::string key, std::vector<double>& target, std::string unit,
                          Range range, std::string description);

  ParameterTable& add(Parameter parameter);

  const std::vector<Parameter>& parameters() const { return parameters_; }

 private:
  std::vector<Parameter> parameters_;
};

/// Throws std::invalid_argument with a line for each number of the table that is out of its range
/// (also in lists), and for each invalid choice. `prefix` is printed before the keys, for example
/// "extended/" or "--".
void requireInRange(const ParameterTable& table, const std::string& prefix);

/// Returns `parameters` if all their values are allowed; throws like requireInRange() otherwise.
/// `section` is their section of the configuration.
template <typename Parameters>
const Parameters& checked(const Parameters& parameters, const char* section) {
  Parameters copy = parameters;
  ParameterTable table;
  copy.declare(table);
  requireInRange(table, std::string(section) + "/");
  return parameters;
}

/// A section of the configuration: its name and its parameters.
struct Section {
  std::string name;
  ParameterTable table;
};
using Sections = std::vector<Section>;

}  // namespace cvg
