#pragma once

#include "ring_gyro/common/angle.h"
#include "ring_gyro/common/parameter_table.h"

namespace cvg {

/// What is told of the device to the loops, the identifiers and the injector. The device itself is
/// in `resonator`, which only the plant reads: the two differ as a data sheet and a part do.
struct DeviceKnowledge {
  double natural_frequency = 0.0;  ///< f0 [Hz]
  double quality_factor = 0.0;     ///< Q
  double drive_gain = 0.0;         ///< ks as the loops assume it [1/s^2]
  double angular_gain = 1.0;       ///< k, pattern angle to angle of the case

  double angularFrequency() const { return kTwoPi * natural_frequency; }          ///< w0 [rad/s]
  double decayRate() const { return 0.5 * angularFrequency() / quality_factor; }  ///< xi0 w0 [1/s]

  /// Throws std::invalid_argument, naming `user`, unless f0 and Q are finite and above zero: all
  /// that a model of the free ring needs.
  void requireResonance(const char* user) const;

  void declare(ParameterTable& table);
};

}  // namespace cvg
