#include "ring_gyro/common/formatted.h"

#include <cstdarg>
#include <cstdio>

namespace cvg {

std::string formatted(const char* pattern, ...) {
  char line[512];
  std::va_list arguments;
  va_start(arguments, pattern);
  std::vsnprintf(line, sizeof line, pattern, arguments);
  va_end(arguments);
  return line;
}

}  // namespace cvg
