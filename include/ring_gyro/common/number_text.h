#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace cvg {

/// The number that a text wholly is, spaces around it aside: decimal, or nan, inf or infinity. The
/// nearest double, infinite when it is beyond the largest, whatever the locale. `decimal`: '.' or
/// ','; the other one is no part of a number.
std::optional<double> parseNumber(std::string_view text, char decimal = '.');

/// The shortest decimal text that reads back as the same number.
std::string textFromNumber(double value);
/// The same at the end of `text`.
void appendNumber(std::string& text, double value);

}  // namespace cvg
