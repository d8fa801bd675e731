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
  bool scaled = false;   ///< whether the first complete period has set the scale; else no value
  bool updated = false;  ///< whether this period's data entered the estimate
  ExtendedVector value;  ///< physical coordinates, in the order of ExtendedIdentifier::names()
  ExtendedMatrix covariance;
  Eigen::Vector4d innovation = Eigen::Vector4d::Zero();             ///< of the mean envelope [V]
  Eigen::Matrix4d innovation_covariance = Eigen::Matrix4d::Zero();  ///< [V^2]
  double normalised_innovation_squared = 0.0;                       ///< 4 is expected
  /// Whether the period was filtered by means of many blocks, the innovation being that of the
  /// last.
  bool whole_period = false;
  /// Whether the filter will not start again; until then innovations and sigmas are of a first
  /// pass.
  bool settled = false;
  double angle_covered = 0.0;   ///< span of theta seen [rad]
  double quality_factor = 0.0;  ///< w0 / (2 xi0 w0)

  double sigma(Eigen::Index state) const;  ///< standard deviation of a state
};

/// The identifier on the envelope of both axes, so that the angle and the phase are measurements
/// beside a and b: gamma, mu and ks, and what the options of ExtendedParameters add.
///
/// Rules for usable blocks, gaps and periods are those of Identifier. The first complete period
/// only sets the scale of ks, by the balance of drive and damping, and the first f0, by the rate of
/// phi.
///
/// Passes: a filter that is linearised at its own estimate believes too much, and goes astray,
/// along directions that are hard to see. So as long as anything is uncertain it is linearised at
/// fixed parameters and at the measured envelope, where the model is linear. After the first
/// second, and then when everything is well known (what is hard to see at one rate: when the rate
/// has been reversed), it starts again at what it found, from its first knowledge but for mu and
/// f0; until a pass finds what it was linearised at. Then `settled`; linearised at the estimate
/// when the cubic term too is well known. What never becomes well known is never settled.
class ExtendedIdentifier {
 public:
  /// Throws std::invalid_argument naming what cannot be used.
  ExtendedIdentifier(const DeviceKnowledge& device, const ExtendedParameters& parameters,
                     const ConverterParameters& converter);

  /// The next block; returns an estimate at each period's end, updated or not. `rotation_rate`:
  /// k Om that acted in the block, as far as known [rad/s]. Does not allocate.
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
  double cubic_at_start_ = 0.0;  // what the filter's cubic term started from [1/V^2]
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
