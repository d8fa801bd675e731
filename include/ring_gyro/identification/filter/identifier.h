#pragma once

#include <cstdint>
#include <string>

#include "ring_gyro/common/converter_parameters.h"
#include "ring_gyro/common/device_knowledge.h"
#include "ring_gyro/common/parameter_table.h"
#include "ring_gyro/identification/filter/block_chain.h"
#include "ring_gyro/identification/filter/first_look.h"
#include "ring_gyro/identification/filter/interval_filter.h"
#include "ring_gyro/identification/filter/period_keeper.h"
#include "ring_gyro/identification/model/averaged_model.h"
#include "ring_gyro/signals/control_gains.h"
#include "ring_gyro/signals/orbital_elements.h"
#include "ring_gyro/signals/parameter_estimate.h"

namespace cvg {

/// Noise of the filter: derived from the parameters below, or the Q and R of the paper.
enum class Tuning : std::uint8_t { kDerived, kPaper };

struct IdentificationParameters {
  double update_period = 0.1;  ///< whole blocks [s]
  /// derived: from the noise and random walks below; paper: instead of these, the Q and R printed
  /// in section 6 of the paper, for each period.
  Tuning tuning = Tuning::kDerived;
  double noise_density = 5e-6;       ///< of the displacement samples, one-sided [V/sqrt(Hz)]
  double axis_process_noise = 2e-6;  ///< of a' and b' [V/sqrt(s)]
  double initial_gamma_sigma = 0.1;
  double initial_mu_sigma = 1e-4;
  double initial_drive_gain_sigma = 0.5;  ///< relative
  double gamma_walk = 0.0;                ///< random walk [1/sqrt(s)]
  double mu_walk = 0.0;                   ///< random walk [1/sqrt(s)]
  double drive_gain_walk = 0.0;           ///< random walk, relative [1/sqrt(s)]
  double memory_time = 0.0;               ///< age at which data count for 1/e; 0: never forget [s]
  double converged_gamma_sigma = 1e-4;    ///< `converged` needs all sigmas below these three
  double converged_mu_sigma = 1e-8;
  double converged_drive_gain_sigma = 5e-4;   ///< relative
  double converged_angle = 3.14159265358979;  ///< span of theta that must have been seen [rad]

  /// Blocks in `update_period`. Throws std::invalid_argument when it is not whole.
  std::int64_t periodBlocks(const ConverterParameters& converter) const;

  void declare(ParameterTable& table);
};

/// The extended Kalman filter (1)-(5),(29)-(33) on the averaged model, fed block by block.
///
/// The elements and gains given together belong to the same block (see PairMerge). BlockChain
/// decides which inputs acted when, and which blocks can be used. The mean of a and b over a period
/// is one measurement (IntervalFilter). Periods end where (sequence + 1) is a multiple of the
/// period, whenever the identifier was started.
///
/// A block that is missing or cannot be used breaks the chain: its period gives no update, a and b
/// start again from the next complete period, the parameters stay.
/// The first complete period only sets the scale of ks, from the balance of drive and damping.
/// At first (for about a second) the parameters are so uncertain that the model is not linear over
/// a whole period. Each block is then an update of its own, which stays even if its period is
/// broken later.
class Identifier {
 public:
  /// Throws std::invalid_argument naming what cannot be used.
  Identifier(const DeviceKnowledge& device, const IdentificationParameters& parameters,
             const ConverterParameters& converter);

  /// The next block; returns an estimate at each period's end, updated or not, and null otherwise.
  /// It is valid until the next call. Elements and gains must have the same session and sequence,
  /// otherwise the block is rejected. After a new session or a sequence that does not grow,
  /// everything starts again. Does not allocate.
  const ParameterEstimate* process(const OrbitalElements& elements, const ControlGains& gains);

  /// Covariance of the last estimate, units of (29). Until the scale of ks has been found, it is
  /// the initial one, which is diagonal.
  StateMatrix covariance() const;

  /// Whether the last block can be used, and if not, why.
  BlockUse lastUse() const { return last_use_; }

  std::int64_t periodBlocks() const { return periods_.periodBlocks(); }
  std::uint64_t restarts() const { return periods_.restarts(); }

 private:
  void take(const Orbit& orbit, const ControlGains& gains);
  double restartSigma(double amplitude) const;
  void breakChain();
  void finishPeriod(const DampingCompensation& compensation);
  bool setScale();
  bool converged() const;
  ParameterVector initialVariance() const;

  IdentificationParameters parameters_;
  AveragedModel model_;
  IntervalFilter filter_;
  PeriodKeeper periods_;
  double period_;        // [s]
  double sample_sigma_;  // of a or b in one block [V]

  BlockChain chain_;
  BlockUse last_use_ = BlockUse::kUsable;
  bool scaled_ = false;     // ks has its scale, the filter runs
  bool chained_ = false;    // the filter's a and b are those of the block before
  bool by_blocks_ = false;  // the present period is filtered block by block
  ParameterEstimate estimate_;
  FirstLookSum first_look_;  // of the present period, until the filter runs
};

}  // namespace cvg
