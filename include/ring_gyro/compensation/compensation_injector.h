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
  double start_after = 0.0;         ///< of data used, before compensation begins [s]
  double gamma_sigma_limit = 2e-4;  ///< opens the gate
  double gamma_limit = 0.15;        ///< largest |gamma| that is ever compensated
  double ramp_rate = 0.05;          ///< of gamma towards its target [1/s]

  void declare(ParameterTable& table);
};

/// Decides what compensation to apply: one decision per estimate, a period ahead, so that it does
/// not matter how fast the machines are. Equation (35) with its sign corrected: the drive
/// 2 xi0 w0 / ks [[g1, g2], [g2, -g1]] v cancels the damping mismatch (g1, g2).
///
/// The first of these that holds decides, each leaves the gains where they are unless said:
/// disabled - ramp to zero; on hold; gate shut (not converged, sigma of a gamma too large,
/// start_after not over, or an estimate that is not finite) - waiting; |gamma| beyond gamma_limit -
/// limited; otherwise ramp towards the estimated gamma, with the estimated ks. A new session begins
/// at zero; enabled and hold outlast it.
class CompensationInjector {
 public:
  /// `period_blocks`: of the identifier. Throws std::invalid_argument naming what cannot be used.
  CompensationInjector(const DeviceKnowledge& device, const InjectorParameters& parameters,
                       std::int64_t period_blocks);

  /// The reference is good until the next call.
  const CompensationDecision& decide(const ParameterEstimate& estimate);

  void setEnabled(bool enabled) { enabled_ = enabled; }
  void setHold(bool hold) { hold_ = hold; }
  /// Back to zero compensation at once, waiting for the gate again.
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
  double drive_gain_ = 0.0;  // that gamma1_ and gamma2_ are turned into gains with; 0: none yet
  CompensationDecision decision_;
};

}  // namespace cvg
