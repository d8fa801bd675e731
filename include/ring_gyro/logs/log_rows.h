#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "ring_gyro/logs/column_map.h"
#include "ring_gyro/logs/log_error.h"
#include "ring_gyro/logs/record_source.h"

namespace cvg {

/// One row of a log in SI units, in the order of Quantity; NaN: not in the log.
using LogRow = Eigen::Array<double, static_cast<int>(kQuantityCount), 1>;

inline double valueOf(const LogRow& row, Quantity quantity) {
  return row[static_cast<Eigen::Index>(indexOf(quantity))];
}

/// Counts of unusable rows by fault.
struct RowFaults {
  std::array<std::uint64_t, static_cast<std::size_t>(RowFault::kCount)> counts{};
  std::string first;  ///< the first of them, as printed text

  std::uint64_t total() const;
  void add(const RowError& error);
};

/// Reads the rows of a log with a column map: applies units and signs, and checks that every number
/// is finite and in the range of its quantity.
class LogRows {
 public:
  /// `mirror`: changes the sign of y and of every quantity that changes sign with y. Throws
  /// LogError for a constant out of range.
  LogRows(RecordSource& source, const ColumnMap& map, bool mirror);

  /// False at the end. Throws RowError for an unusable row, LogError for an unusable log.
  bool next(LogRow& row);
  std::uint64_t count() const { return count_; }  ///< rows read, good or not
  std::string place() const { return source_.place(); }
  double done() const { return source_.done(); }
  double size() const { return source_.size(); }

 private:
  RecordSource& source_;
  const ColumnMap& map_;
  bool mirror_;
  std::vector<Quantity> selected_;
  std::vector<double> read_;
  LogRow constants_;
  std::uint64_t count_ = 0;
};

}  // namespace cvg
