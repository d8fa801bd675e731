#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace cvg {

/// Rows of numbers under column names, read once from begin to end.
class RecordSource {
 public:
  virtual ~RecordSource() = default;

  virtual const std::vector<std::string>& names() const = 0;
  /// Whether the names are the file's own; otherwise they are "1", "2", ...
  virtual bool named() const { return true; }
  /// The columns that next() fills, in this order. To be called before next().
  virtual void select(const std::vector<std::size_t>& columns) = 0;
  /// False at the end. Throws RowError for a row that cannot be read (the next call goes on behind
  /// it), LogError for a file that cannot.
  virtual bool next(std::vector<double>& values) = 0;
  /// Of the last row: "line 12".
  virtual std::string place() const = 0;
  /// How much has been read and how much there is [bytes].
  virtual double done() const = 0;
  virtual double size() const = 0;
  /// Its format, as a person reads it.
  virtual std::string format() const = 0;
};

/// How a text log is written; zero: guess.
struct CsvDialect {
  char delimiter = 0;
  char decimal = 0;  ///< '.' or ','
  std::size_t skipped_lines = 0;
};

/// A MATLAB file (by its first bytes) or else a text log. Throws LogError.
std::unique_ptr<RecordSource> openLog(const std::string& path, const CsvDialect& dialect = {});

}  // namespace cvg
