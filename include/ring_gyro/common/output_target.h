#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace cvg {

/// What a path leads to as an output, links followed.
struct OutputTarget {
  /// A regular file that is there or can be made; one that is written into and never replaced
  /// (device, pipe, terminal); a descriptor of this very process (/dev/stdout, /dev/fd/3).
  enum class Kind { kFile, kStream, kDescriptor };

  Kind kind = Kind::kFile;
  std::filesystem::path folder;  ///< of the file
  std::string name;              ///< in that folder
  int descriptor = -1;
};

/// Follows relative and absolute links, chains of them, and one whose target is not there yet.
/// Throws std::runtime_error with the line of writeFault: a folder, a circle of links.
OutputTarget outputTarget(const std::string& path);

/// Refuses, before anything is written, an output that is the same file as an input or as another
/// output, however either is spelled: ./x, a link, a hard link. Names that are empty are passed
/// over; so is what is no file to be destroyed (/dev/null, a terminal). Throws std::runtime_error.
void requireApart(const std::vector<std::string>& outputs, const std::vector<std::string>& inputs);

}  // namespace cvg
