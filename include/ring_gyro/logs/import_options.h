#pragma once

#include <cstdint>
#include <optional>

namespace cvg {

/// Conventions of the lab that wrote the log.
struct ImportOptions {
  /// When the gains of a row acted: until the row's time, from then on, or they are values at that
  /// moment.
  enum class GainTiming { kBefore, kAfter, kAt };

  std::optional<double> sample_rate;  ///< rows a second, when there is no (good) time column [Hz]
  GainTiming gain_timing = GainTiming::kBefore;
  double group_delay = 0.0;          ///< from a row's time back to where its motion is valid [s]
  std::optional<double> drive_gain;  ///< ks as the lab's loops assumed it [1/s^2]
  /// From when the motion that the drive was pointed by is valid, to where it was pointed; none: to
  /// the middle of the time in which it acted [s].
  std::optional<double> drive_lead;
  double phi_offset = 0.0;   ///< added to the log's phi [rad]
  bool mirror = false;       ///< the lab's theta grows from x to -y
  std::int64_t average = 0;  ///< rows in a block; 0: as many as make about 1 ms
  /// Below it a block is not used; none: 0.9 of the median over the first rows [V].
  std::optional<double> minimum_amplitude;
  double stopband_attenuation = 120.0;  ///< of the demodulator, for samples [dB]
  bool partial = false;                 ///< leave out rows that cannot be used, and count them
  std::uint32_t session = 1;
};

}  // namespace cvg
