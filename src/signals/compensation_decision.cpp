#include "ring_gyro/signals/compensation_decision.h"

namespace cvg {

const char* toString(InjectorState state) {
  switch (state) {
    case InjectorState::kDisabled:
      return "disabled";
    case InjectorState::kWaiting:
      return "waiting";
    case InjectorState::kTracking:
      return "tracking";
    case InjectorState::kHolding:
      return "holding";
    case InjectorState::kLimited:
      return "limited";
  }
  return "unknown";
}

}  // namespace cvg
