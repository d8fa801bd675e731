#include "ring_gyro/logs/log_rows.h"

#include <cmath>
#include <limits>
#include <numeric>

#include "ring_gyro/common/number_text.h"

namespace cvg {
namespace {

constexpr Quantity kMirrored[] = {Quantity::kTheta,
                                  Quantity::kB,
                                  Quantity::kAlpha,
                                  Quantity::kVirtualRate,
                                  Quantity::kSteeringVolts,
                                  Quantity::kQuadratureVolts,
                                  Quantity::kCompensationGain2,
                                  Quantity::kDriveYReal,
                                  Quantity::kDriveYImag,
                                  Quantity::kCy,
                                  Quantity::kSy,
                                  Quantity::kY};

std::vector<std::size_t> columnsOf(const ColumnMap& map, std::vector<Quantity>& selected) {
  std::vector<std::size_t> columns;
  for (const QuantityInfo& info : quantities()) {
    const std::optional<ColumnUse>& use = map.use(info.quantity);
    if (!use || !use->column) continue;
    selected.push_back(info.quantity);
    columns.push_back(*use->column);
  }
  return columns;
}

std::string outOfRange(const QuantityInfo& info, double value) {
  std::string text = std::string(info.name) + " = ";
  appendNumber(text, value);
  const std::string unit = siUnit(info.dimension);
  return text + " " + unit + " is out of range; allowed: " + info.range.text() + " " + unit;
}

}  // namespace

std::uint64_t RowFaults::total() const {
  return std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
}

void RowFaults::add(const RowError& error) {
  if (total() == 0) first = error.what();
  ++counts[static_cast<std::size_t>(error.kind())];
}

LogRows::LogRows(RecordSource& source, const ColumnMap& map, bool mirror)
    : source_(source), map_(map), mirror_(mirror) {
  source_.select(columnsOf(map_, selected_));
  constants_.setConstant(std::numeric_limits<double>::quiet_NaN());
  for (const QuantityInfo& info : quantities()) {
    const std::optional<ColumnUse>& use = map_.use(info.quantity);
    if (use && !use->column) {
      if (!info.range.contains(use->constant)) {
        throw LogError(map_.file(), std::string("--constant ") + info.name,
                       outOfRange(info, use->constant), "give its unit too, such as omega=14195Hz");
      }
      constants_[static_cast<Eigen::Index>(indexOf(info.quantity))] = use->constant;
    }
  }
}

bool LogRows::next(LogRow& row) {
  ++count_;
  if (!source_.next(read_)) {
    --count_;
    return false;
  }
  row = constants_;
  for (std::size_t k = 0; k < selected_.size(); ++k) {
    const ColumnUse& use = *map_.use(selected_[k]);
    if (!std::isfinite(read_[k])) {
      std::string value;
      appendNumber(value, read_[k]);
      throw RowError(RowFault::kNotFinite, map_.file(),
                     source_.place() + ", column " + map_.names()[*use.column], "is " + value,
                     "mend it, or leave such rows out with --partial");
    }
    const QuantityInfo& info = infoOf(selected_[k]);
    const double value = use.scale * read_[k];
    if (!info.range.contains(value)) {
      throw RowError(RowFault::kOutOfRange, map_.file(),
                     source_.place() + ", column " + map_.names()[*use.column],
                     outOfRange(info, value),
                     std::string("if it has another unit say --column ") + info.name +
                         "=COLUMN:UNIT (or a factor); --partial leaves such rows out");
    }
    row[static_cast<Eigen::Index>(indexOf(selected_[k]))] = value;
  }
  if (mirror_) {
    for (const Quantity quantity : kMirrored) {
      row[static_cast<Eigen::Index>(indexOf(quantity))] *= -1.0;
    }
  }
  return true;
}

}  // namespace cvg
