#pragma once

#include "ring_gyro/signals/envelope.h"

namespace cvg {

/// Known inputs of the envelope model over one step.
struct EnvelopeInput {
  Envelope drive = Envelope::Zero();  ///< commanded envelope, with driveStep() [V]
  double reference_frequency = 0.0;   ///< w [rad/s]
  double theta = 0.0;                 ///< measured, in the middle of the step [rad]
  double rotation_rate = 0.0;         ///< k Om, as far as it is known [rad/s]
};

}  // namespace cvg
