#pragma once

#include <string>

namespace cvg {

/// As std::printf prints it; lines of up to 511 characters.
#if defined(__GNUC__)
__attribute__((format(printf, 1, 2)))
#endif
std::string
formatted(const char* pattern, ...);

}  // namespace cvg
