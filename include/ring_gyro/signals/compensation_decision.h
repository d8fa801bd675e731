#pragma once

#include <cstdint>

#include "ring_gyro/signals/control_gains.h"

namespace cvg {

/// State of the injector, for display and for the latched status.
enum class InjectorState : std::uint8_t {
  kDisabled = 0,  ///< switched off: ramping to or at zero
  kWaiting = 1,   ///< estimate not good enough yet
  kTracking = 2,  ///< following the estimate
  kHolding = 3,   ///< frozen by request
  kLimited = 4,   ///< the estimate is beyond gamma_limit: not followed
};

const char* toString(InjectorState state);

/// A decision, valid from the drive of block `effective_sequence` until the next one.
struct CompensationDecision {
  std::uint32_t session = 0;
  std::uint64_t effective_sequence = 0;
  std::uint64_t data_sequence = 0;  ///< last block of the estimate it came from
  DampingCompensation gains;
  double gamma1 = 0.0;  ///< mismatch that the gains cancel if the estimate of ks is right
  double gamma2 = 0.0;
  InjectorState state = InjectorState::kWaiting;
};

}  // namespace cvg
