#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace cvg {

enum class Dimension { kTime, kVoltage, kAngle, kAngularRate, kNone };

const char* siUnit(Dimension dimension);
/// The known units, for messages: "s, ms, us, ...".
std::string knownUnits(Dimension dimension);

/// SI units per unit of a text such as "deg", "kHz", "2deg" or a bare factor "1.5e-3"; empty when
/// the text is not a unit of this dimension.
std::optional<double> unitScale(std::string_view text, Dimension dimension);
/// Whether the text is a unit of any dimension.
bool isUnit(std::string_view text);

/// SI value of "14195 Hz", "-90deg" or a bare number in SI. Throws std::invalid_argument, naming
/// `name`.
double quantityFromText(const std::string& name, const std::string& text, Dimension dimension);

}  // namespace cvg
