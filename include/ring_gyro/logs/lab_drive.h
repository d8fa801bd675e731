#pragma once

#include <optional>

#include "ring_gyro/logs/column_map.h"
#include "ring_gyro/logs/log_rows.h"
#include "ring_gyro/signals/control_gains.h"
#include "ring_gyro/signals/orbital_elements.h"

namespace cvg {

/// The drive that acted according to a log: its logged envelopes or, if there are none, the drive
/// computed by (28) from the gains or their voltages and the measured orbit.
class LabDrive {
 public:
  /// `drive_gain`: ks as the lab's loops assumed it, for steering by a virtual rate [1/s^2].
  LabDrive(const ColumnMap& map, std::optional<double> drive_gain);

  /// Sets gains and drive of `target` from those of `row`, pointed along `orbit`.
  /// Throws std::invalid_argument when the row has a virtual rate and the drive gain is not known.
  void rebuild(const LogRow& row, const Orbit& orbit, ControlGains& target) const;

 private:
  bool envelopes_;
  std::optional<double> drive_gain_;
};

}  // namespace cvg
