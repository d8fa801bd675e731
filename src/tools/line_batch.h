#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "line_file.h"
#include "ring_gyro/common/item_range.h"

namespace ring_gyro::tools {

// Batches whose items are numbers and whose results are one line of JSON each, {"index": n, ...}.
// They can be sharded, resumed and merged.

/// The complete lines of files, by index.
using LinesByIndex = std::map<std::uint64_t, std::string>;

/// Throws when a line is not of this batch: one of nlohmann's exceptions for a line of another
/// program, or std::runtime_error with the reason.
using LineCheck = std::function<void(std::uint64_t index, const nlohmann::ordered_json& line)>;

/// Shard K of N from "K/N", K from 0 to N - 1; empty: all. Throws boost::program_options::error.
void setShard(const std::string& text, cvg::ItemRange& range);

/// The lines of several files, without duplicates and in order; also written to `output` unless
/// that is empty. Throws std::runtime_error, naming file and line, when a line is not of this kind
/// or differs from another with the same index.
LinesByIndex mergeLines(const std::string& program, const std::vector<std::string>& files,
                        const std::string& output, const LineCheck& check);

/// The file of a running batch.
class LineBatch {
 public:
  /// With `resume` the lines in `path` count as done, except an incomplete last line. Without it
  /// the file must not contain anything. Throws std::runtime_error with one line: path, reason,
  /// remedy.
  LineBatch(const std::string& program, const std::string& path, bool resume,
            const LineCheck& check);

  /// The items of the range that are not done.
  std::vector<std::uint64_t> left(const cvg::ItemRange& range) const;
  /// Adds a line, including its line end; one thread at a time.
  void add(std::uint64_t index, const std::string& line);
  /// Puts all lines on the disk.
  void finish() { file_.finish(); }

  const LinesByIndex& lines() const { return lines_; }

 private:
  LineFile file_;
  LinesByIndex lines_;
};

/// The item as one line, for any bytes in its texts.
std::string asLine(const nlohmann::ordered_json& item);

}  // namespace ring_gyro::tools
