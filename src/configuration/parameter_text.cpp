#include "ring_gyro/configuration/parameter_text.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "ring_gyro/common/number_text.h"

namespace cvg {
namespace {

std::string lowerCase(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

std::string checkNumber(const Parameter& parameter, double value) {
  if (!std::isfinite(value)) return "not finite";
  return parameter.range.contains(value) ? "" : "out of range";
}

std::string store(const Parameter& parameter, double* target, const std::string& text) {
  const std::optional<double> value = numberFromText(text);
  if (!value) return "not a number";
  std::string fault = checkNumber(parameter, *value);
  if (fault.empty()) *target = *value;
  return fault;
}

std::string store(const Parameter& parameter, std::int64_t* target, const std::string& text) {
  const std::optional<double> value = numberFromText(text);
  if (!value) return "not a whole number";
  if (!std::isfinite(*value)) return "not finite";
  if (*value != std::round(*value)) return "not a whole number";
  constexpr double kExactlyRepresentable = 9007199254740992.0;
  if (std::abs(*value) > kExactlyRepresentable) return "out of range";
  std::string fault = checkNumber(parameter, *value);
  if (fault.empty()) *target = static_cast<std::int64_t>(*value);
  return fault;
}

std::string store(const Parameter&, bool* target, const std::string& text) {
  const std::string name = lowerCase(text);
  if (name != "true" && name != "false") return "not true or false";
  *target = name == "true";
  return "";
}

std::string store(const Parameter&, std::string* target, const std::string& text) {
  *target = text;
  return "";
}

std::string store(const Parameter&, const Parameter::Choice& target, const std::string& text) {
  const auto found = std::find(target.names.begin(), target.names.end(), text);
  if (found == target.names.end()) return "unknown choice";
  *target.value = static_cast<std::uint8_t>(found - target.names.begin());
  return "";
}

std::string store(const Parameter&, std::vector<double>*, const std::string&) {
  return "not a list of numbers";
}

/// A parameter server would read a whole number as an integer, which has only 32 bits.
std::string text(const double* value) {
  const std::string text = textFromNumber(*value);
  const bool whole = text.find_first_not_of("-0123456789") == std::string::npos;
  return whole && std::abs(*value) > 2147483647.0 ? text + ".0" : text;
}
std::string text(const std::int64_t* value) { return std::to_string(*value); }
std::string text(const bool* value) { return *value ? "true" : "false"; }
std::string text(const Parameter::Choice& choice) { return *choice; }
std::string text(const std::string* value) { return value->empty() ? "\"\"" : *value; }
std::string text(const std::vector<double>* values) {
  std::string result = "[";
  for (const double value : *values) {
    if (result.size() > 1) result += ", ";
    result += text(&value);
  }
  return result + "]";
}

}  // namespace

std::optional<double> numberFromText(const std::string& text) {
  // YAML writes these with a point: .nan, -.inf.
  const std::size_t point = text.find('.');
  const bool sign = !text.empty() && (text[0] == '+' || text[0] == '-');
  const bool word = point == (sign ? 1 : 0) && point + 1 < text.size() &&
                    std::isalpha(static_cast<unsigned char>(text[point + 1])) != 0;
  return parseNumber(word ? text.substr(0, point) + text.substr(point + 1) : text);
}

std::string storeText(const Parameter& parameter, const std::string& text) {
  return std::visit([&](const auto& target) { return store(parameter, target, text); },
                    parameter.target);
}

std::string allowedText(const Parameter& parameter) {
  if (std::holds_alternative<bool*>(parameter.target)) return "true or false";
  if (std::holds_alternative<std::string*>(parameter.target)) return "any text";
  if (const auto* const choice = std::get_if<Parameter::Choice>(&parameter.target)) {
    std::string result = "one of: ";
    for (const std::string& name : choice->names) {
      if (&name != &choice->names.front()) result += ", ";
      result += name;
    }
    return result;
  }
  std::string result = parameter.range.text();
  if (std::holds_alternative<std::int64_t*>(parameter.target)) return result + ", whole";
  if (std::holds_alternative<std::vector<double>*>(parameter.target))
    result = "list, each " + result;
  return result + " [" + parameter.unit + "]";
}

std::string valueText(const Parameter& parameter) {
  return std::visit([](const auto& target) { return text(target); }, parameter.target);
}

}  // namespace cvg
