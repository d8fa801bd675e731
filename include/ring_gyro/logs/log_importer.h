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

/// What became of the rows of a log.
struct ImportCounts {
  std::uint64_t rows = 0;  ///< read, good or not
  RowFaults faults;
  std::uint64_t missing_rows = 0;     ///< gaps in time, where rows should have been
  std::uint64_t left_over_rows = 0;   ///< good, but of a block that is not whole
  std::uint64_t blocks = 0;           ///< handed on
  std::uint64_t unusable_blocks = 0;  ///< of these: not locked, or marked so in the log
  double duration = 0.0;              ///< from the first to the last row [s]
  double lowest_theta = 0.0;          ///< of usable blocks [rad]
  double highest_theta = 0.0;         ///< [rad]
  double mean_beta = 0.0;             ///< of usable blocks [s]
};

/// Turns the rows of a log into what the identifier takes: elements and gains, block by block.
///
/// Rows are put onto an even grid; missing rows become missing sequences. theta is unwrapped and
/// phi brought to (-pi, 0]. Samples x, y go through the package's demodulator; when their
/// reference phase is not in the log, phi is taken as locked at -pi/2. A log without flags is taken
/// as locked where a is not small, b is under a tenth of a and phi within 30 deg of -pi/2.
class LogImporter {
 public:
  using Sink = std::function<void(const OrbitalElements&, const ControlGains&)>;
  using Progress = std::function<void(double done, double size)>;

  /// Looks at the first rows. Source and map must live as long. Throws LogError when the log cannot
  /// be used, also for a bad row unless options.partial;
  /// std::invalid_argument for options that cannot.
  LogImporter(RecordSource& source, const ColumnMap& map, const ImportOptions& options);

  const LogRow& firstRow() const { return head_.front().row; }
  double rowPeriod() const { return clock_->period(); }  ///< [s]
  std::int64_t rowsPerBlock() const { return rows_per_block_; }
  std::int64_t blockDurationNanoseconds() const { return duration_ns_; }
  double groupDelay() const;           ///< of the blocks, unless the log says it [s]
  std::string groupDelayText() const;  ///< how long, or which column says it

  /// Everything to the end of the log. Throws as the constructor.
  const ImportCounts& run(const Sink& sink, const Progress& progress);

 private:
  struct HeadRow {
    LogRow row;
    std::string place;
  };
  /// A row or a block: where the orbit was, and what the log says beside it.
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
  std::vector<HeadRow> head_;  // first good rows, by which period and conventions are seen
  std::optional<RowClock> clock_;
  std::int64_t rows_per_block_ = 1;
  std::int64_t duration_ns_ = 0;
  double minimum_amplitude_ = 0.0;
  const Sink* sink_ = nullptr;

  bool started_ = false;
  std::int64_t first_block_ = 0;
  std::int64_t origin_ns_ = 0;      // end of the first block
  std::int64_t row_index_ = 0;      // on the grid
  std::int64_t next_in_block_ = 0;  // row of a block that is awaited; negative: none of this block
  std::optional<Moment> last_;      // the one before, when nothing is missing between
  std::optional<double> last_theta_;
  double theta_rate_ = 0.0;
  bool rate_known_ = false;

  std::unique_ptr<Demodulator> demodulator_;
  DisplacementBlock samples_;
  std::int64_t blocks_to_settle_ = 0;
  double reference_phase_ = 0.0;  // integrated, at the next sample

  Moment block_;  // sums over its rows
  ControlGains block_gains_;
};

}  // namespace cvg
