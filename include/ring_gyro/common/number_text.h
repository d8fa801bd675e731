#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace cvg {

/// The number in a text that contains nothing else but spaces around it: decimal, or nan, inf or
/// infinity; otherwise nothing. Gives the nearest double (infinite beyond the largest double) in
/// every locale. `decimal` is '.' or ','; the other character is not accepted in a number.
std::optional<double> parseNumber(std::string_view text, char decimal = '.');

/// The shortest decimal text that reads back as the same number.
std::string textFromNumber(double value);
/// The same at the end of `text`.
void appendNumber(std::string& text, double value);

}  // namespace cvg
