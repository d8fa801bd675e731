#pragma once

#include <cstdint>

namespace cvg {

/// Why the numbers of a block were refused when they arrived.
enum class Refusal : std::uint8_t {
  kNone,
  kNotFinite,      ///< NaN, infinite, or so large that a square could overflow
  kImpossible,     ///< for example a negative group delay
  kContradiction,  ///< a total that is not the sum of its parts
};

/// Status of one block; a usable block is locked and has no fault.
struct LoopStatus {
  bool amplitude_locked = false;     ///< a within 1 % of its setpoint for 50 ms
  bool quadrature_locked = false;    ///< |b| under 1 % of a for 50 ms
  bool phase_locked = false;         ///< phi within 0.5 deg of -90 deg for 50 ms
  bool invalid_samples = false;      ///< NaN or infinite samples, or wrong count: the loops coast
  bool converter_saturated = false;  ///< samples at the limit of the converter's range
  bool drive_saturated = false;      ///< the drive that acted was scaled to its limit, or clipped
  Refusal refused = Refusal::kNone;  ///< why the numbers are not used; not in any message

  bool locked() const { return amplitude_locked && quadrature_locked && phase_locked; }
  bool usable() const {
    return locked() && !invalid_samples && !converter_saturated && !drive_saturated &&
           refused == Refusal::kNone;
  }
};

}  // namespace cvg
