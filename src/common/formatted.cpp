#include "ring_gyro/common/formatted.h"

#include <cstdarg>
#include <cstdio>
#include <stdexcept>

namespace cvg {

std::string formatted(const char* pattern, ...) {
  std::va_list arguments;
  va_start(arguments, pattern);
  std::va_list again;
  va_copy(again, arguments);
  // First the length, then the text.
  const int length = std::vsnprintf(nullptr, 0, pattern, arguments);
  va_end(arguments);
  std::string text(length > 0 ? static_cast<std::size_t>(length) : 0, '\0');
  if (length > 0) std::vsnprintf(text.data(), text.size() + 1, pattern, again);
  va_end(again);
  if (length < 0) throw std::invalid_argument(std::string("cannot print '") + pattern + "'");
  return text;
}

}  // namespace cvg
