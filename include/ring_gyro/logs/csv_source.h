#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "ring_gyro/logs/line_reader.h"
#include "ring_gyro/logs/record_source.h"

namespace cvg {

/// Fields of one line; a delimiter in quotes does not separate fields. A space as the delimiter
/// means one or more blanks. The views refer to `line`.
void splitFields(std::string_view line, char delimiter, std::vector<std::string_view>& fields);

/// A text log with delimiters. The following are found from its first lines unless they are given:
/// comment lines (#, %), lines before the table, the header, a line of units, delimiter and decimal
/// sign.
class CsvSource : public RecordSource {
 public:
  /// Throws LogError.
  CsvSource(const std::string& path, const CsvDialect& dialect);

  const std::vector<std::string>& names() const override { return names_; }
  bool named() const override { return named_; }
  void select(const std::vector<std::size_t>& columns) override { columns_ = columns; }
  bool next(std::vector<double>& values) override;
  std::string place() const override;
  double done() const override { return lines_.done(); }
  double size() const override { return lines_.size(); }
  std::string format() const override;

 private:
  [[noreturn]] void failRagged(std::size_t fields) const;
  [[noreturn]] void failNumber(std::size_t column, std::string_view field) const;

  CsvDialect dialect_;
  LineReader lines_;
  std::uint64_t first_line_ = 1;  // first line with numbers
  std::vector<std::string> names_;
  bool named_ = false;
  bool split_at_decimals_ = false;  // decimal commas may have been taken for delimiters
  std::vector<std::size_t> columns_;
  std::vector<std::string_view> fields_;
};

}  // namespace cvg
