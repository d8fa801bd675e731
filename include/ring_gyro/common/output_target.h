#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace cvg {

/// The output that a path names, after following links.
struct OutputTarget {
  /// A regular file that exists or can be made; a stream, which is written directly and never
  /// replaced (device, pipe, terminal); a descriptor of this process (/dev/stdout, /dev/fd/3).
  enum class Kind { kFile, kStream, kDescriptor };

  Kind kind = Kind::kFile;
  std::filesystem::path folder;  ///< of the file
  std::string name;              ///< in that folder
  int descriptor = -1;
};

/// Follows relative and absolute links, chains of links, and a link whose target does not exist
/// yet. Throws std::runtime_error with the line of writeFault for a folder or a circle of links.
OutputTarget outputTarget(const std::string& path);

/// Throws std::runtime_error, before anything is written, if an output is the same file as an input
/// or another output, even under another spelling: ./x, a link, a hard link. Ignores empty names
/// and outputs that are not files (/dev/null, a terminal).
void requireApart(const std::vector<std::string>& outputs, const std::vector<std::string>& inputs);

}  // namespace cvg
