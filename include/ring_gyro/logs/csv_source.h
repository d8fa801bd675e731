#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "ring_gyro/logs/line_reader.h"
#include "ring_gyro/logs/record_source.h"

namespace cvg {

/// Fields of one line; quotes keep a delimiter from parting. A space stands for any run of blanks.
/// The views are into `line`.
void splitFields(std::string_view line, char delimiter, std::vector<std::string_view>& fields);

/// A text log with delimiters. What is not given is found from its first lines: comment lines (#,
/// %), lines before the table, the header, a line of units, delimiter and decimal sign.
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
  std::uint64_t first_line_ = 1;  // with numbers
  std::vector<std::string> names_;
  bool named_ = false;
  bool split_at_decimals_ = false;  // perhaps
  std::vector<std::size_t> columns_;
  std::vector<std::string_view> fields_;
};

}  // namespace cvg
