#include "ring_gyro/identification/filter/identifier.h"

#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

#include "ring_gyro/common/square.h"

namespace cvg {
namespace {

// Variance of a state of which nothing is known yet: finite, so that it can be sent and plotted.
constexpr double kUnknownVariance = 1e30;
// Section 6 of the paper, in the order of (29), for one update per period. With this much noise the
// model is never linear over a period, so the noise is spread over the updates by blocks.
constexpr std::array<double, 7> kPaperProcessNoise = {1e-4, 1e-4, 1.0, 1.0, 1e-2, 1e-2, 1e7};
constexpr double kPaperMeasurementNoise = 1e-4;

IntervalNoise intervalNoise(const IdentificationParameters& parameters, double block_duration,
                            std::int64_t period_blocks) {
  IntervalNoise noise;
  if (parameters.tuning == Tuning::kPaper) {
    const double blocks = static_cast<double>(period_blocks);
    noise.sample_variance = kPaperMeasurementNoise * blocks;
    noise.axes_density = kPaperProcessNoise[kA] / (blocks * block_duration);
  } else {
    // Demodulation gives each quadrature noise of the two-sided density N^2; with its moving
    // average a sample has the variance N^2 / block duration.
    const double density = square(parameters.noise_density);
    noise.sample_variance = density / block_duration;
    noise.axes_density = square(parameters.axis_process_noise);
    noise.angle_density = density;
  }
  return noise;
}

}  // namespace

std::int64_t IdentificationParameters::periodBlocks(const ConverterParameters& converter) const {
  return converter.wholeBlocks(update_period, "identification/update_period");
}

void IdentificationParameters::declare(ParameterTable& table) {
  table
      .number("update_period", update_period, "s", Range::between(1e-6, 10.0),
              "a whole number of blocks; their mean is one measurement")
      .choice("tuning", tuning, {"derived", "paper"},
              "noise of the filter: derived from the figures below, or the Q and R of the paper")
      .number("noise_density", noise_density, "V/sqrt(Hz)", Range::between(1e-12, 1.0),
              "of the displacement samples, white, one-sided")
      .number("axis_process_noise", axis_process_noise, "V/sqrt(s)", Range::between(0.0, 1.0),
              "white noise of a' and b' for effects that are not in the averaged model")
      .number("initial_gamma_sigma", initial_gamma_sigma, "1", Range::between(1e-9, 1.0),
              "sigma of gamma1 and gamma2 before any data")
      .number("initial_mu_sigma", initial_mu_sigma, "1", Range::between(1e-12, 1e-2),
              "sigma of mu1 and mu2 before any data")
      .number("initial_drive_gain_sigma", initial_drive_gain_sigma, "1", Range::between(1e-9, 10.0),
              "sigma of ks before any data, relative to its value from the first period")
      .number("gamma_walk", gamma_walk, "1/sqrt(s)", Range::between(0.0, 1.0),
              "random walk of gamma1 and gamma2; 0: constant")
      .number("mu_walk", mu_walk, "1/sqrt(s)", Range::between(0.0, 1e-2),
              "random walk of mu1 and mu2; 0: constant")
      .number("drive_gain_walk", drive_gain_walk, "1/sqrt(s)", Range::between(0.0, 1.0),
              "random walk of ks, relative; 0: constant")
      .number("memory_time", memory_time, "s", Range::atLeast(0.0),
              "age at which data count for 1/e, where newer data show the same; 0: never forget")
      .number("converged_gamma_sigma", converged_gamma_sigma, "1", Range::above(0.0),
              "converged needs both sigmas of gamma below this")
      .number("converged_mu_sigma", converged_mu_sigma, "1", Range::above(0.0),
              "converged needs both sigmas of mu below this")
      .number("converged_drive_gain_sigma", converged_drive_gain_sigma, "1", Range::above(0.0),
              "converged needs the sigma of ks, relative to ks, below this")
      .number("converged_angle", converged_angle, "rad", Range::atLeast(0.0),
              "converged needs at least this span of theta in the data used");
}

Identifier::Identifier(const DeviceKnowledge& device, const IdentificationParameters& parameters,
                       const ConverterParameters& converter)
    : parameters_(checked(parameters, "identification")),
      model_(device),
      filter_(
          model_,
          intervalNoise(parameters, converter.blockDuration(), parameters.periodBlocks(converter)),
          converter.blockDuration()),
      periods_(parameters.periodBlocks(converter)),
      period_(static_cast<double>(periodBlocks()) * converter.blockDuration()),
      sample_sigma_(parameters.noise_density / std::sqrt(converter.blockDuration())),
      chain_(converter.blockDurationNanoseconds()) {}

const ParameterEstimate* Identifier::process(const OrbitalElements& elements,
                                             const ControlGains& gains) {
  const PeriodKeeper::Follows how = periods_.follow(elements.stamp);
  if (how == PeriodKeeper::Follows::kNothing) scaled_ = chained_ = false;
  if (how == PeriodKeeper::Follows::kAfterGap) breakChain();
  last_use_ = chain_.admit(elements, gains, 0.0);
  if (last_use_ != BlockUse::kUsable) {
    periods_.spoil();
    breakChain();
  } else if (periods_.complete()) {
    take(elements.orbit, gains);
  }
  if (!periods_.atLastBlock()) return nullptr;
  finishPeriod(gains.compensation);
  return &estimate_;
}

/// Uses the block that the chain has just admitted.
inline void Identifier::take(const Orbit& orbit, const ControlGains& gains) {
  const bool first_of_period = periods_.atFirstBlock();
  if (first_of_period) first_look_ = FirstLookSum();
  periods_.see(orbit.theta);
  if (!scaled_) {
    first_look_.add(orbit, gains.drive.total(), gains.reference_frequency);
    return;
  }
  const Eigen::Vector2d axes(orbit.a, orbit.b);
  const bool restarted = !chained_;
  if (restarted) filter_.restartAxes(axes, restartSigma(orbit.a));
  chained_ = true;
  if (first_of_period) {
    const auto blocks = static_cast<int>(periodBlocks());
    by_blocks_ = blocks == 1 || !filter_.isLinearOver(blocks, gains.reference_frequency);
  }
  if (restarted) {
    filter_.sample(axes);
  } else if (by_blocks_) {
    filter_.stepAndUpdate(chain_.step(model_.decayRate()), axes);
  } else {
    filter_.step(chain_.step(model_.decayRate()), axes);
  }
  // The sample of a restart alone is no measurement: the axes were set to it.
  const bool updated = by_blocks_ && !restarted;
  if (!updated && !periods_.atLastBlock()) return;
  if (!updated) filter_.update();
  chained_ = filter_.lastUpdate().accepted;
  if (!chained_) periods_.spoil();
}

double Identifier::restartSigma(double amplitude) const {
  // Wide enough that the mean of the period counts, not one sample.
  return 0.01 * std::abs(amplitude) + 10.0 * sample_sigma_;
}

/// The next block cannot continue from the filter's a and b.
void Identifier::breakChain() {
  if (!chained_) return;
  const Eigen::Vector2d axes = filter_.value().head<2>();
  filter_.restartAxes(axes, restartSigma(axes[0]));
  chained_ = false;
}

void Identifier::finishPeriod(const DampingCompensation& compensation) {
  ParameterEstimate& estimate = estimate_;
  estimate.updated = periods_.complete() && scaled_;
  bool used = estimate.updated;
  if (estimate.updated) {
    const IntervalUpdate& update = filter_.lastUpdate();
    estimate.innovation = update.innovation;
    estimate.innovation_covariance = update.innovation_covariance;
    estimate.normalised_innovation_squared = update.normalised_innovation_squared;
  } else {
    estimate.innovation.setZero();
    estimate.innovation_covariance.setZero();
    estimate.normalised_innovation_squared = 0.0;
    used = periods_.complete() && setScale();
  }
  periods_.finish(used);

  estimate.stamp = periods_.last();
  estimate.first_sequence = periods_.firstSequence();
  estimate.used_blocks = periods_.used();
  estimate.rejected_blocks = periods_.rejected();
  estimate.lost_blocks = periods_.lost();
  estimate.angle_covered = periods_.angleCovered();
  if (scaled_) {
    estimate.value = filter_.value();
    estimate.parameter_variance = filter_.parameterVariance();
  } else {
    estimate.value.setZero();
    estimate.parameter_variance = initialVariance();
  }
  estimate.covariance.setTo(*this);
  const double cancelled_by_gain = 0.5 * estimate.value[kDriveGain] / model_.decayRate();
  estimate.residual_gamma1 = estimate.value[kGamma1];
  estimate.residual_gamma2 = estimate.value[kGamma2];
  if (std::isfinite(compensation.gain1) && std::isfinite(compensation.gain2)) {
    estimate.residual_gamma1 -= cancelled_by_gain * compensation.gain1;
    estimate.residual_gamma2 -= cancelled_by_gain * compensation.gain2;
  }
  estimate.converged = converged();
}

bool Identifier::setScale() {
  const FirstLook look = first_look_.look(chain_.blockDuration(), model_.decayRate());
  if (!(look.drive_gain > 0.0) || !std::isfinite(look.drive_gain)) return false;

  StateVector value = StateVector::Zero();
  value[kA] = look.amplitude;
  value[kDriveGain] = look.drive_gain;
  const double axis_sigma = restartSigma(look.amplitude);
  StateVector sigma;
  sigma << axis_sigma, axis_sigma, parameters_.initial_gamma_sigma, parameters_.initial_gamma_sigma,
      parameters_.initial_mu_sigma, parameters_.initial_mu_sigma,
      parameters_.initial_drive_gain_sigma * look.drive_gain;
  ParameterVector walk;
  if (parameters_.tuning == Tuning::kPaper) {
    for (int k = 0; k < 5; ++k) walk[k] = std::sqrt(kPaperProcessNoise[k + 2] / period_);
  } else {
    walk << parameters_.gamma_walk, parameters_.gamma_walk, parameters_.mu_walk,
        parameters_.mu_walk, parameters_.drive_gain_walk * look.drive_gain;
  }
  filter_.initialise(value, sigma, walk, parameters_.memory_time);
  scaled_ = true;
  return true;
}

bool Identifier::converged() const {
  const double gamma = square(parameters_.converged_gamma_sigma);
  const double mu = square(parameters_.converged_mu_sigma);
  const auto variance = [this](StateIndex index) { return estimate_.variance(index); };
  return scaled_ && variance(kGamma1) < gamma && variance(kGamma2) < gamma && variance(kMu1) < mu &&
         variance(kMu2) < mu &&
         variance(kDriveGain) <
             square(parameters_.converged_drive_gain_sigma * estimate_.value[kDriveGain]) &&
         estimate_.angle_covered >= parameters_.converged_angle;
}

/// Variances of the parameters until the scale of ks has been found.
ParameterVector Identifier::initialVariance() const {
  const double gamma = square(parameters_.initial_gamma_sigma);
  const double mu = square(parameters_.initial_mu_sigma);
  return (ParameterVector() << gamma, gamma, mu, mu, kUnknownVariance).finished();
}

StateMatrix Identifier::covariance() const {
  if (scaled_) return filter_.covariance();
  StateVector variance;
  variance << kUnknownVariance, kUnknownVariance, initialVariance();
  return StateMatrix(variance.asDiagonal());
}

}  // namespace cvg
