#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "ring_gyro/common/converter_parameters.h"
#include "ring_gyro/common/device_knowledge.h"
#include "ring_gyro/identification/filter/block_chain.h"
#include "ring_gyro/identification/filter/envelope_filter.h"
#include "ring_gyro/identification/filter/first_look.h"
#include "ring_gyro/identification/filter/period_keeper.h"
#include "ring_gyro/identification/model/extended_parameters.h"

namespace cvg {

/// Result of one period of the extended identifier.
struct ExtendedEstimate {
  BlockStamp stamp;  ///< last block of the period
  std::uint64_t used_blocks = 0;
  std::uint64_t rejected_blocks = 0;
  std::uint64_t lost_blocks = 0;
  bool scaled = false;   ///< whether the first complete period has set the scale; if not, no value
  bool updated = false;  ///< whether this period's data entered the estimate
  ExtendedVector value;  ///< physical coordinates, in the order of ExtendedIdentifier::names()
  ExtendedMatrix covariance;
  Eigen::Vector4d innovation = Eigen::Vector4d::Zero();             ///< of the mean envelope [V]
  Eigen::Matrix4d innovation_covariance = Eigen::Matrix4d::Zero();  ///< [V^2]
  double normalised_innovation_squared = 0.0;                       ///< 4 is expected
  /// Whether each update of the period used the mean of many blocks; the innovation is that of the
  /// last update.
  bool whole_period = false;
  /// True when the filter will not start again. Until then innovations and sigmas are preliminary.
  bool settled = false;
  double angle_covered = 0.0;   ///< span of theta seen [rad]
  double quality_factor = 0.0;  ///< w0 / (2 xi0 w0)

  double sigma(Eigen::Index state) const;  ///< standard deviation of a state
};

/// The identifier that measures the envelope of both axes, so that the angle and the phase are
/// measurements as well as a and b. It estimates gamma, mu and ks, and what the options of
/// ExtendedParameters add.
///
/// The rules for usable blocks, gaps and periods are those of Identifier. The first complete period
/// only sets the scale of ks, from the balance of drive and damping, and the first f0, from the
/// rate of phi.
///
/// Passes: along directions that the data show poorly, a filter that is linearised at its own
/// estimate becomes too sure and drifts away. So it is first linearised at fixed parameters and at
/// the measured envelope, where the model is linear. The first pass ends after ten periods, the
/// others when everything is well known (what one rate shows poorly becomes well known when the
/// rate has been reversed). The filter then starts again, linearised at what it has
/// found. Its prior is that before any data, except for mu and f0. The passes end when one finds
/// the parameters at which it was linearised: `settled`. After that the filter is linearised at its
/// estimate as soon as the cubic term is well known too. If something never becomes well known, the
/// filter never settles.
class ExtendedIdentifier {
 public:
  /// Throws std::invalid_argument naming what cannot be used.
  ExtendedIdentifier(const DeviceKnowledge& device, const ExtendedParameters& parameters,
                     const ConverterParameters& converter);

  /// The next block; returns an estimate at each period's end, updated or not. `rotation_rate`:
  /// k Om that acted in the block, as far as it is known [rad/s]. Does not allocate.
  std::optional<ExtendedEstimate> process(const OrbitalElements& elements,
                                          const ControlGains& gains, double rotation_rate = 0.0);

  const std::vector<std::string>& names() const { return state_.names(); }
  /// Index of a name; empty when it is not estimated.
  std::optional<Eigen::Index> find(const std::string& name) const { return state_.find(name); }
  std::int64_t periodBlocks() const { return periods_.periodBlocks(); }

 private:
  void gather();
  void propagate();
  std::uint64_t updateBlocks() const;
  void breakChain();
  bool setScale();
  void reconsider();
  void start(const ExtendedVector& value, const ExtendedVector& sigma,
             const ExtendedVector& nominal);
  void startAgain();
  ExtendedEstimate finishPeriod();
  double restartSigma(double amplitude) const;

  ExtendedParameters parameters_;
  ExtendedState state_;
  PeriodKeeper periods_;
  double block_duration_;
  double sample_sigma_;
  EnvelopeFilter filter_;
  BlockChain chain_;

  bool scaled_ = false;
  double cubic_at_start_ = 0.0;  // cubic term at which this pass is linearised [1/V^2]
  bool settled_ = false;         // will not start again
  int passes_ = 0;
  int periods_of_pass_ = 0;
  ExtendedVector first_value_;  // before any data, physical coordinates
  ExtendedVector first_sigma_;
  bool chained_ = false;             // the filter's envelope is that at the end of the last period
  std::uint64_t update_blocks_ = 1;  // blocks whose mean is one update
  bool by_blocks_ = false;           // the present period is filtered block by block
  EnvelopeUpdate update_;
  FirstLookSum first_look_;
};

}  // namespace cvg
