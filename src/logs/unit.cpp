#include "ring_gyro/logs/unit.h"

#include <algorithm>
#include <array>
#include <boost/algorithm/string/predicate.hpp>
#include <boost/algorithm/string/trim.hpp>
#include <cmath>
#include <stdexcept>

#include "ring_gyro/common/angle.h"
#include "ring_gyro/common/number_text.h"

namespace cvg {
namespace {

struct UnitInfo {
  const char* name;
  Dimension dimension;
  double scale;
};

constexpr double kDegree = toRadians(1.0);

// The first unit whose name matches exactly is used, otherwise the first that matches in another
// case.
constexpr std::array<UnitInfo, 56> kUnits = {{
    {"s", Dimension::kTime, 1.0},
    {"ms", Dimension::kTime, 1e-3},
    {"us", Dimension::kTime, 1e-6},
    {"\xC2\xB5s", Dimension::kTime, 1e-6},
    {"\xCE\xBCs", Dimension::kTime, 1e-6},
    {"\xB5s", Dimension::kTime, 1e-6},
    {"ns", Dimension::kTime, 1e-9},
    {"min", Dimension::kTime, 60.0},
    {"sec", Dimension::kTime, 1.0},
    {"V", Dimension::kVoltage, 1.0},
    {"mV", Dimension::kVoltage, 1e-3},
    {"uV", Dimension::kVoltage, 1e-6},
    {"\xC2\xB5V", Dimension::kVoltage, 1e-6},
    {"\xCE\xBCV", Dimension::kVoltage, 1e-6},
    {"\xB5V", Dimension::kVoltage, 1e-6},
    {"nV", Dimension::kVoltage, 1e-9},
    {"rad", Dimension::kAngle, 1.0},
    {"mrad", Dimension::kAngle, 1e-3},
    {"urad", Dimension::kAngle, 1e-6},
    {"deg", Dimension::kAngle, kDegree},
    {"degree", Dimension::kAngle, kDegree},
    {"degrees", Dimension::kAngle, kDegree},
    {"\xC2\xB0", Dimension::kAngle, kDegree},
    {"\xB0", Dimension::kAngle, kDegree},
    {"mdeg", Dimension::kAngle, 1e-3 * kDegree},
    {"arcsec", Dimension::kAngle, kDegree / 3600.0},
    {"rev", Dimension::kAngle, kTwoPi},
    {"turn", Dimension::kAngle, kTwoPi},
    {"turns", Dimension::kAngle, kTwoPi},
    {"cycles", Dimension::kAngle, kTwoPi},
    {"rad/s", Dimension::kAngularRate, 1.0},
    {"krad/s", Dimension::kAngularRate, 1e3},
    {"mrad/s", Dimension::kAngularRate, 1e-3},
    {"deg/s", Dimension::kAngularRate, kDegree},
    {"\xC2\xB0/s", Dimension::kAngularRate, kDegree},
    {"\xB0/s", Dimension::kAngularRate, kDegree},
    {"mdeg/s", Dimension::kAngularRate, 1e-3 * kDegree},
    {"deg/h", Dimension::kAngularRate, kDegree / 3600.0},
    {"dps", Dimension::kAngularRate, kDegree},
    {"rpm", Dimension::kAngularRate, kTwoPi / 60.0},
    {"rev/s", Dimension::kAngularRate, kTwoPi},
    {"Hz", Dimension::kAngularRate, kTwoPi},
    {"kHz", Dimension::kAngularRate, 1e3 * kTwoPi},
    {"MHz", Dimension::kAngularRate, 1e6 * kTwoPi},
    {"mHz", Dimension::kAngularRate, 1e-3 * kTwoPi},
    {"1", Dimension::kNone, 1.0},
    {"-", Dimension::kNone, 1.0},
    {"V/V", Dimension::kNone, 1.0},
    {"mV/V", Dimension::kNone, 1e-3},
    {"uV/V", Dimension::kNone, 1e-6},
    {"%", Dimension::kNone, 1e-2},
    {"percent", Dimension::kNone, 1e-2},
    {"ppm", Dimension::kNone, 1e-6},
    {"V/(V/s)", Dimension::kTime, 1.0},
    {"mV/(V/s)", Dimension::kTime, 1e-3},
    {"uV/(V/s)", Dimension::kTime, 1e-6},
}};

const UnitInfo* find(std::string_view name, std::optional<Dimension> dimension) {
  const auto matches = [&](const UnitInfo& unit) {
    return !dimension || unit.dimension == *dimension;
  };
  for (const UnitInfo& unit : kUnits) {
    if (name == unit.name && matches(unit)) return &unit;
  }
  for (const UnitInfo& unit : kUnits) {
    if (boost::iequals(name, unit.name) && matches(unit)) return &unit;
  }
  return nullptr;
}

/// Longest beginning of the text that is a number, and what follows it.
struct NumberAndRest {
  std::optional<double> number;
  std::string rest;
};

NumberAndRest splitNumber(const std::string& text) {
  const std::size_t not_digits = text.find_first_not_of("0123456789.+-eE");
  for (std::size_t length = std::min(not_digits, text.size()); length > 0; --length) {
    if (const auto number = parseNumber(text.substr(0, length))) {
      return {number, boost::algorithm::trim_copy(text.substr(length))};
    }
  }
  return {std::nullopt, text};
}

}  // namespace

const char* siUnit(Dimension dimension) {
  switch (dimension) {
    case Dimension::kTime:
      return "s";
    case Dimension::kVoltage:
      return "V";
    case Dimension::kAngle:
      return "rad";
    case Dimension::kAngularRate:
      return "rad/s";
    case Dimension::kNone:
      break;
  }
  return "1";
}

std::string knownUnits(Dimension dimension) {
  std::string result;
  for (const UnitInfo& unit : kUnits) {
    if (unit.dimension != dimension || (unit.name[0] & 0x80) != 0) continue;
    result += (result.empty() ? "" : ", ") + std::string(unit.name);
  }
  return result;
}

std::optional<double> unitScale(std::string_view text, Dimension dimension) {
  const std::string name = boost::algorithm::trim_copy(std::string(text));
  if (const UnitInfo* unit = find(name, dimension)) return unit->scale;
  const auto [factor, rest] = splitNumber(name);
  if (!factor || *factor == 0.0) return std::nullopt;
  if (rest.empty()) return *factor;
  const UnitInfo* unit = find(rest, dimension);
  if (!unit) return std::nullopt;
  return *factor * unit->scale;
}

bool isUnit(std::string_view text) { return find(text, std::nullopt) != nullptr; }

double quantityFromText(const std::string& name, const std::string& text, Dimension dimension) {
  const auto [number, rest] = splitNumber(boost::algorithm::trim_copy(text));
  if (number && !std::isfinite(*number)) {
    throw std::invalid_argument(name + " = " + text + " is not finite");
  }
  if (number && rest.empty()) return *number;
  const UnitInfo* unit = number ? find(rest, dimension) : nullptr;
  if (!unit) {
    throw std::invalid_argument(name + " = " + text + " is no number with a unit out of " +
                                knownUnits(dimension));
  }
  return *number * unit->scale;
}

}  // namespace cvg
