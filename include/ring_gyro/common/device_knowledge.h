#pragma once

#include "ring_gyro/common/angle.h"
#include "ring_gyro/common/parameter_table.h"

namespace cvg {

/// Nominal values of the device, for the loops, the identifiers and the injector. The true values
/// are in `resonator`, and only the plant reads them: the two differ like a data sheet and a part.
struct DeviceKnowledge {
  double natural_frequency = 0.0;  ///< f0 [Hz]
  double quality_factor = 0.0;     ///< Q
  double drive_gain = 0.0;         ///< ks as the loops assume it [1/s^2]
  double angular_gain = 1.0;       ///< k, pattern angle per angle of the case

  double angularFrequency() const { return kTwoPi * natural_frequency; }          ///< w0 [rad/s]
  double decayRate() const { return 0.5 * angularFrequency() / quality_factor; }  ///< xi0 w0 [1/s]

  /// Throws std::invalid_argument, naming `user`, unless f0 and Q are finite and above zero. A
  /// model of the free ring needs nothing else.
  void requireResonance(const char* user) const;

  void declare(ParameterTable& table);
};

}  // namespace cvg
