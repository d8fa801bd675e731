#pragma once

#include <cstddef>
#include <string>

namespace cvg {

/// One line for a file or folder that could not be written: which, the reason (an errno), the mend.
std::string writeFault(const std::string& path, int reason);

/// Writes all of it to a descriptor, in as many calls as that takes, so that the reason for which
/// one fails is its own. A pipe whose reader has gone is a reason too, not a signal. Throws
/// std::runtime_error with the line of writeFault for `path`.
void writeAll(int descriptor, const char* data, std::size_t size, const std::string& path);

}  // namespace cvg
