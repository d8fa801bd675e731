#pragma once

#include <string>
#include <vector>

#include "ring_gyro/logs/record_source.h"

namespace cvg {

/// A MATLAB file, v5 to v7.3. A vector is a column with the vector's name; a column of a matrix is
/// "name(:,k)", a vector in a scalar struct is "struct.name"; a scalar holds for all rows. The
/// selected columns are kept in memory.
class MatSource : public RecordSource {
 public:
  /// Throws LogError.
  explicit MatSource(const std::string& path);

  const std::vector<std::string>& names() const override { return names_; }
  void select(const std::vector<std::size_t>& columns) override;
  bool next(std::vector<double>& values) override;
  std::string place() const override { return "row " + std::to_string(row_); }
  double done() const override { return 8.0 * static_cast<double>(row_ * data_.size()); }
  double size() const override { return 8.0 * static_cast<double>(rows_ * data_.size()); }
  std::string format() const override { return "MATLAB file"; }

 private:
  struct Column {
    std::string variable;
    std::string field;  // of a struct; empty: the variable itself
    std::size_t column = 0;
    std::size_t rows = 0;
  };

  std::string path_;
  std::vector<Column> all_;
  std::vector<std::string> names_;
  std::vector<std::vector<double>> data_;
  std::size_t rows_ = 0;
  std::size_t row_ = 0;  // from 1, of the last row
};

}  // namespace cvg
