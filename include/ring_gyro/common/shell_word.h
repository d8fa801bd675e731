#pragma once

#include <string>

namespace cvg {

/// A path as one word of a shell command in a message to the user: quoted where needed, and written
/// so that the command does not take it for an option.
std::string shellWord(const std::string& path);

}  // namespace cvg
