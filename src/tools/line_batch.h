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

// Batches whose items are numbers and whose results are one line of JSON each, {"index": n, ...}:
// in shards, gone on with after a stop, and merged.

/// The whole lines of files, by index.
using LinesByIndex = std::map<std::uint64_t, std::string>;

/// Throws why a line is none of this batch: nlohmann's exceptions when it is of another program, or
/// std::runtime_error with the reason.
using LineCheck = std::function<void(std::uint64_t index, const nlohmann::ordered_json& line)>;

/// Shard K of N from "K/N", K from 0 to N - 1; empty: all. Throws boost::program_options::error.
void setShard(const std::string& text, cvg::ItemRange& range);

/// The lines of several files as one, without duplicates and in order, in `output` unless that is
/// empty. Throws std::runtime_error naming file and line where one is not of this kind, or differs
/// from one with the same index.
LinesByIndex mergeLines(const std::string& program, const std::vector<std::string>& files,
                        const std::string& output, const LineCheck& check);

/// The file of a batch that runs.
class LineBatch {
 public:
  /// What `path` holds counts as done with `resume`, a last line without its end aside; without it
  /// there must be nothing. Throws std::runtime_error with one line: path, reason, mend.
  LineBatch(const std::string& program, const std::string& path, bool resume,
            const LineCheck& check);

  /// Those of the range that are not done.
  std::vector<std::uint64_t> left(const cvg::ItemRange& range) const;
  /// One line more, its end included; by one thread at a time.
  void add(std::uint64_t index, const std::string& line);
  /// All lines are on the disk.
  void finish() { file_.finish(); }

  const LinesByIndex& lines() const { return lines_; }

 private:
  LineFile file_;
  LinesByIndex lines_;
};

/// One line, whatever bytes a path in a message has.
std::string asLine(const nlohmann::ordered_json& item);

}  // namespace ring_gyro::tools
