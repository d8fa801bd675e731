#pragma once

#include <cstdint>
#include <optional>

namespace cvg {

/// Conventions of the lab that wrote the log.
struct ImportOptions {
  /// When the gains of a row acted: before the row's time, after it, or they are values at that
  /// time.
  enum class GainTiming { kBefore, kAfter, kAt };

  std::optional<double> sample_rate;  ///< of the rows, if there is no good time column [Hz]
  GainTiming gain_timing = GainTiming::kBefore;
  double group_delay = 0.0;          ///< a row's time minus the time of its motion [s]
  std::optional<double> drive_gain;  ///< ks as the lab's loops assumed it [1/s^2]
  /// How far ahead of the measured motion the drive was pointed [s]; none: to the middle of the
  /// time in which it acted.
  std::optional<double> drive_lead;
  double phi_offset = 0.0;   ///< added to the log's phi [rad]
  bool mirror = false;       ///< the lab's theta grows from x to -y
  std::int64_t average = 0;  ///< rows in a block; 0: as many as make about 1 ms
  /// A block with a smaller a is not used [V]; none: 0.9 of the median over the first rows.
  std::optional<double> minimum_amplitude;
  double stopband_attenuation = 120.0;  ///< of the demodulator, for samples [dB]
  bool partial = false;                 ///< omit and count unusable rows
  std::uint32_t session = 1;
};

}  // namespace cvg
