#pragma once

#include <string>

namespace cvg {

/// A path as a word of a shell command that a user is told: quoted where it must be, never an
/// option.
std::string shellWord(const std::string& path);

}  // namespace cvg
