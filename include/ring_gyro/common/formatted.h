#pragma once

#include <string>

namespace cvg {

/// As std::printf prints it, however long. Throws std::invalid_argument for what it cannot print.
#if defined(__GNUC__)
__attribute__((format(printf, 1, 2)))
#endif
std::string
formatted(const char* pattern, ...);

}  // namespace cvg
