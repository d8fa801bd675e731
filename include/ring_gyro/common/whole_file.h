#pragma once

#include <string>

namespace ring_gyro {

/// Writes a text file whole or not at all: beside its place first, then renamed.
/// Throws std::runtime_error naming the file and the reason.
void writeWholeFile(const std::string& path, const std::string& text);

/// Whether writeWholeFile could write there now: to be told before a long run rather than after it.
/// Throws as that does.
void requireWritable(const std::string& path);

}  // namespace ring_gyro
