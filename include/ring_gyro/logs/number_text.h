#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace cvg {

/// The number that a field of a log wholly is, spaces around it aside: decimal, or nan or inf.
/// The nearest double, whatever the locale. `decimal`: '.' or ','.
std::optional<double> parseNumber(std::string_view text, char decimal = '.');

/// Appends a decimal text that reads back as the same number.
void appendNumber(std::string& text, double value);

}  // namespace cvg
