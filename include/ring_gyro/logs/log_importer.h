#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ring_gyro/demodulation/demodulator.h"
#include "ring_gyro/logs/column_map.h"
#include "ring_gyro/logs/import_options.h"
#include "ring_gyro/logs/lab_drive.h"
#include "ring_gyro/logs/log_rows.h"
#include "ring_gyro/logs/row_clock.h"
#include "ring_gyro/signals/control_gains.h"
#include "ring_gyro/signals/orbital_elements.h"

namespace cvg {

/// Counts and results of an import.
struct ImportCounts {
  std::uint64_t rows = 0;  ///< all rows read, good or bad
  RowFaults faults;
  std::uint64_t missing_rows = 0;     ///< rows missing in gaps in time
  std::uint64_t left_over_rows = 0;   ///< good rows of incomplete blocks
  std::uint64_t blocks = 0;           ///< sent to the sink
  std::uint64_t unusable_blocks = 0;  ///< of these: not locked, or marked unusable in the log
  double duration = 0.0;              ///< from the first to the last row [s]
  double lowest_theta = 0.0;          ///< of usable blocks [rad]
  double highest_theta = 0.0;         ///< [rad]
  double mean_beta = 0.0;             ///< of usable blocks [s]
};

/// Converts the rows of a log to the input of the identifier: elements and gains, block by block.
///
/// Rows are assigned to an even grid; missing rows become missing sequences. theta is unwrapped and
/// phi shifted to (-pi, 0]. The package's demodulator processes samples x, y; if their reference
/// phase is not in the log, phi is assumed locked at -pi/2. In a log without flags, blocks count as
/// locked where a is not small, b is under a tenth of a and phi within 30 deg of -pi/2.
class LogImporter {
 public:
  using Sink = std::function<void(const OrbitalElements&, const ControlGains&)>;
  using Progress = std::function<void(double done, double size)>;

  /// Reads the first rows. `source` and `map` must outlive this object. Throws LogError when the
  /// log cannot be used, also for a bad row unless options.partial is set, and
  /// std::invalid_argument for unusable options.
  LogImporter(RecordSource& source, const ColumnMap& map, const ImportOptions& options);

  const LogRow& firstRow() const { return head_.front().row; }
  double rowPeriod() const { return clock_->period(); }  ///< [s]
  std::int64_t rowsPerBlock() const { return rows_per_block_; }
  std::int64_t blockDurationNanoseconds() const { return duration_ns_; }
  double groupDelay() const;           ///< of the blocks, unless the log has a column for it [s]
  std::string groupDelayText() const;  ///< the delay, or the column that contains it

  /// Converts the log to its end. Throws like the constructor.
  const ImportCounts& run(const Sink& sink, const Progress& progress);

 private:
  struct HeadRow {
    LogRow row;
    std::string place;
  };
  /// A row or a block: its orbit, and the other values of the log.
  struct Moment {
    Orbit orbit;
    LogRow row;
  };

  bool has(Quantity quantity) const { return map_.has(quantity); }
  bool nextGood(LogRow& row, const std::function<void(const RowError&)>& note_fault);
  void note(const RowError& error);
  void readHead();
  void choosePeriod();
  void chooseBlocks();
  void makeDemodulator();
  void chooseAmplitude();
  void checkPhase() const;
  void checkDelay() const;
  [[noreturn]] void fail(const std::string& place, const std::string& fault,
                         const std::string& mend) const;

  void take(const LogRow& row, const std::string& place);
  void checkRow(const LogRow& row, const std::string& place) const;
  std::int64_t rowsSinceLast(const LogRow& row, const std::string& place);
  void setOrigin(const LogRow& row, const std::string& place);
  bool beginOrContinueBlock(bool contiguous);
  void breakBlock();
  void checkTheta(const LogRow& row, const std::string& place);
  void addMotion(const LogRow& row);
  void addSample(const LogRow& row);
  void finishSamples();
  Orbit orbitOf(const LogRow& row) const;
  Orbit onBranch(Orbit orbit);
  void trackRate(const Orbit& orbit, double period);
  void driveOf(const LogRow& acted, const Orbit& now, double period, double group_delay,
               ControlGains& gains) const;
  void addToBlock(const Moment& moment, const ControlGains& gains);
  void emit();
  bool locked(const Orbit& orbit) const;

  const ColumnMap& map_;
  ImportOptions options_;
  LogRows rows_;
  LabDrive drive_;
  ImportCounts counts_;
  std::vector<HeadRow> head_;  // first good rows, to determine period and conventions
  std::optional<RowClock> clock_;
  std::int64_t rows_per_block_ = 1;
  std::int64_t duration_ns_ = 0;
  double minimum_amplitude_ = 0.0;
  const Sink* sink_ = nullptr;

  bool started_ = false;
  std::int64_t first_block_ = 0;
  std::int64_t origin_ns_ = 0;      // end of the first block
  std::int64_t row_index_ = 0;      // on the grid
  std::int64_t next_in_block_ = 0;  // expected row of the block; negative: none of this block
  std::optional<Moment> last_;      // the previous one, if nothing is missing in between
  std::optional<double> last_theta_;
  double theta_rate_ = 0.0;
  bool rate_known_ = false;

  std::unique_ptr<Demodulator> demodulator_;
  DisplacementBlock samples_;
  std::int64_t blocks_to_settle_ = 0;
  double reference_phase_ = 0.0;  // integrated up to the next sample

  Moment block_;  // sums over its rows
  ControlGains block_gains_;
};

}  // namespace cvg
