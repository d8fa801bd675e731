#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace cvg {

/// Rows of numbers under column names, read once from beginning to end.
class RecordSource {
 public:
  virtual ~RecordSource() = default;

  virtual const std::vector<std::string>& names() const = 0;
  /// Whether the names are the file's own; otherwise they are "1", "2", ...
  virtual bool named() const { return true; }
  /// Selects the columns that next() fills, in this order. Call it before next().
  virtual void select(const std::vector<std::size_t>& columns) = 0;
  /// False at the end. Throws RowError for a row that cannot be read (the next call reads the row
  /// after it), LogError for a file that cannot be read.
  virtual bool next(std::vector<double>& values) = 0;
  /// Place of the last row: "line 12".
  virtual std::string place() const = 0;
  /// Bytes read, and bytes in total.
  virtual double done() const = 0;
  virtual double size() const = 0;
  /// The format as printed text.
  virtual std::string format() const = 0;
};

/// Format of a text log; zero: guess.
struct CsvDialect {
  char delimiter = 0;
  char decimal = 0;  ///< '.' or ','
  std::size_t skipped_lines = 0;
};

/// Opens a MATLAB file (recognised by its first bytes) or a text log. Throws LogError.
std::unique_ptr<RecordSource> openLog(const std::string& path, const CsvDialect& dialect = {});

}  // namespace cvg
