#pragma once

#include <cstddef>
#include <string>

namespace cvg {

/// One line for a file or folder that could not be written: path, reason (an errno), remedy.
std::string writeFault(const std::string& path, int reason);

/// Writes all bytes to a descriptor, in as many calls as needed; so after a short write the next
/// call reports the true reason. A pipe without a reader is such a reason too, not a signal. Throws
/// std::runtime_error with the line of writeFault for `path`.
void writeAll(int descriptor, const char* data, std::size_t size, const std::string& path);

}  // namespace cvg
