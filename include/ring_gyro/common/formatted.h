#pragma once

#include <string>

namespace cvg {

/// The text that std::printf would print, of any length. Throws std::invalid_argument if printing
/// fails.
#if defined(__GNUC__)
__attribute__((format(printf, 1, 2)))
#endif
std::string
formatted(const char* pattern, ...);

}  // namespace cvg
