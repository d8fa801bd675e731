#pragma once

#include <cstdint>
#include <string>

#include "ring_gyro/common/device_knowledge.h"
#include "ring_gyro/common/parameter_table.h"
#include "ring_gyro/signals/compensation_decision.h"
#include "ring_gyro/signals/parameter_estimate.h"

namespace cvg {

struct InjectorParameters {
  bool enabled = true;              ///< at the start
  double start_after = 0.0;         ///< time of data used before compensation begins [s]
  double gamma_sigma_limit = 2e-4;  ///< largest sigma of gamma for compensation
  double gamma_limit = 0.15;        ///< largest |gamma| that is compensated
  double ramp_rate = 0.05;          ///< of gamma towards its target [1/s]

  void declare(ParameterTable& table);
};

/// Decides which compensation to apply: one decision per estimate, for one period later, so that
/// the result does not depend on the speed of the machine. Equation (35) with its sign corrected:
/// the drive 2 xi0 w0 / ks [[g1, g2], [g2, -g1]] v cancels the damping mismatch (g1, g2).
///
/// The first condition that is true decides:
///
/// - disabled: the gains ramp to zero;
/// - on hold: the gains stay;
/// - not converged, a sigma of gamma too large, less than start_after of data, or an estimate that
///   is not finite: waiting, the gains stay;
/// - |gamma| beyond gamma_limit: limited, the gains stay;
/// - otherwise the gains ramp towards the estimated gamma, with the estimated ks.
///
/// A new session begins with zero gains; enabled and hold stay as they are.
class CompensationInjector {
 public:
  /// `period_blocks`: of the identifier. Throws std::invalid_argument, naming a parameter that
  /// cannot be used.
  CompensationInjector(const DeviceKnowledge& device, const InjectorParameters& parameters,
                       std::int64_t period_blocks);

  /// The returned reference is valid until the next call.
  const CompensationDecision& decide(const ParameterEstimate& estimate);

  void setEnabled(bool enabled) { enabled_ = enabled; }
  void setHold(bool hold) { hold_ = hold; }
  /// Back to zero compensation at once; then waits for a good estimate again.
  void reset();

 private:
  bool gateOpen(const ParameterEstimate& estimate) const;
  void rampTowards(double gamma1, double gamma2, double duration);

  InjectorParameters parameters_;
  double damping_;  // 2 xi0 w0 [1/s]
  std::int64_t period_blocks_;
  bool enabled_;
  bool hold_ = false;
  bool begun_ = false;
  std::uint32_t session_ = 0;
  double gamma1_ = 0.0;
  double gamma2_ = 0.0;
  double drive_gain_ = 0.0;  // ks that converts gamma1_ and gamma2_ to gains; 0: none yet
  CompensationDecision decision_;
};

}  // namespace cvg
