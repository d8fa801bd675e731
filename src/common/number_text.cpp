#include "ring_gyro/common/number_text.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <limits>

#if !defined(__cpp_lib_to_chars)
#include <locale.h>
#else
#include <locale>
#include <sstream>
#endif

namespace cvg {
namespace {

constexpr std::size_t kLongest = 400;  // characters of a number

// GCC 9 of Ubuntu 20.04 has no std::from_chars of floating point: strtod in the C locale instead.
#if defined(__cpp_lib_to_chars)
bool convert(const char* begin, const char* end, double& value) {
  const auto [stop, error] = std::from_chars(begin, end, value);
  if (stop != end || error == std::errc::invalid_argument) return false;
  if (error != std::errc::result_out_of_range) return true;
  // Too large or too small: from_chars does not say which.
  std::istringstream in(std::string(begin, end));
  in.imbue(std::locale::classic());
  in >> value;
  if (in.fail()) {
    value = *begin == '-' ? -std::numeric_limits<double>::infinity()
                          : std::numeric_limits<double>::infinity();
  }
  return true;
}

char* print(char* begin, char* end, double value) { return std::to_chars(begin, end, value).ptr; }
#else
locale_t plainLocale() {
  static const locale_t locale = newlocale(LC_ALL_MASK, "C", nullptr);
  return locale;
}

bool convert(const char* begin, const char* end, double& value) {
  std::array<char, kLongest + 1> text;
  *std::copy(begin, end, text.begin()) = '\0';
  char* stop = nullptr;
  value = strtod_l(text.data(), &stop, plainLocale());
  return stop == text.data() + (end - begin);
}

char* print(char* begin, char* end, double value) {
  const locale_t before = uselocale(plainLocale());
  int length = 0;
  for (int digits = 1; digits <= std::numeric_limits<double>::max_digits10; ++digits) {
    length = std::snprintf(begin, static_cast<std::size_t>(end - begin), "%.*g", digits, value);
    double back = 0.0;
    if (convert(begin, begin + length, back) && back == value) break;
  }
  uselocale(before);
  return begin + length;
}
#endif

bool isBlank(char c) { return c == ' ' || c == '\t'; }
bool isSign(char c) { return c == '+' || c == '-'; }

}  // namespace

std::optional<double> parseNumber(std::string_view text, char decimal) {
  while (!text.empty() && isBlank(text.front())) text.remove_prefix(1);
  while (!text.empty() && isBlank(text.back())) text.remove_suffix(1);
  if (!text.empty() && text.front() == '+') {
    text.remove_prefix(1);
    if (!text.empty() && isSign(text.front())) return std::nullopt;
  }
  if (text.empty() || text.size() > kLongest) return std::nullopt;
  // Check the first character: both converters would accept more, such as hexadecimal or "nan(1)".
  const char first = text.front() == '-' && text.size() > 1 ? text[1] : text.front();
  const bool digits = std::isdigit(static_cast<unsigned char>(first)) != 0 || first == decimal;
  const bool word = first == 'n' || first == 'N' || first == 'i' || first == 'I';
  if (!digits && !word) return std::nullopt;
  if (text.find_first_of("xX(") != std::string_view::npos) return std::nullopt;
  std::array<char, kLongest> copy;
  if (decimal != '.') {
    if (text.find('.') != std::string_view::npos) return std::nullopt;
    std::replace_copy(text.begin(), text.end(), copy.begin(), decimal, '.');
    text = {copy.data(), text.size()};
  }
  double value = 0.0;
  if (!convert(text.data(), text.data() + text.size(), value)) return std::nullopt;
  return value;
}

void appendNumber(std::string& text, double value) {
  std::array<char, 40> buffer;
  char* const end = print(buffer.data(), buffer.data() + buffer.size(), value);
  text.append(buffer.data(), static_cast<std::size_t>(end - buffer.data()));
}

std::string textFromNumber(double value) {
  std::string text;
  appendNumber(text, value);
  return text;
}

}  // namespace cvg
