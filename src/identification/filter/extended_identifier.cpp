#include "ring_gyro/identification/filter/extended_identifier.h"

#include <algorithm>
#include <cmath>

#include "ring_gyro/common/square.h"
#include "ring_gyro/demodulation/orbit.h"
#include "ring_gyro/identification/filter/extended_prior.h"

namespace cvg {
namespace {

// Limits for the cubic term, as a relative change of the orbit: with a sigma below kCubicFound it
// is found; if it differs by less than kCubicOff from where the pass was linearised, the pass is
// good; with a sigma below kCubicSharp it is safe to linearise at the estimate.
constexpr double kCubicFound = 2e-4;
constexpr double kCubicOff = 4e-4;
constexpr double kCubicSharp = 2e-5;

// Most that the envelope may turn or decay during one mean.
constexpr double kMostTurn = 0.5;

// Factor on the sigmas found in one pass that become the prior of the next.
constexpr double kWidening = 10.0;
// A pass takes at least kLeastPeriods periods; a parameter is found when its sigma is below
// kFoundShare of its prior sigma.
constexpr int kLeastPeriods = 10;
constexpr double kFoundShare = 0.1;
// Largest sigma of the matrix of the rates, relative to the decay rate, with which it is safe to
// linearise at the estimate.
constexpr double kMatrixSharp = 0.005;
// Largest distance of that matrix from the one at which the pass was linearised, relative to the
// decay rate, with which the pass is good.
constexpr double kMatrixNear = 0.05;

EnvelopeInput inputOf(const BlockChain::Block& block) {
  return {block.drive, block.reference_frequency, block.orbit.theta, block.rotation_rate};
}

}  // namespace

double ExtendedEstimate::sigma(Eigen::Index state) const {
  return std::sqrt(covariance(state, state));
}

ExtendedIdentifier::ExtendedIdentifier(const DeviceKnowledge& device,
                                       const ExtendedParameters& parameters,
                                       const ConverterParameters& converter)
    : parameters_(checked(parameters, "extended")),
      state_(device, parameters),
      periods_(parameters.periodBlocks(converter)),
      block_duration_(converter.blockDuration()),
      sample_sigma_(parameters.noise_density / std::sqrt(block_duration_)),
      // Demodulation gives each quadrature noise of the two-sided density N^2; with its moving
      // average a sample has the variance N^2 / block duration.
      filter_(EnvelopeModel(state_), square(sample_sigma_), block_duration_,
              square(parameters.envelope_process_noise)),
      chain_(converter.blockDurationNanoseconds()) {}

std::optional<ExtendedEstimate> ExtendedIdentifier::process(const OrbitalElements& elements,
                                                            const ControlGains& gains,
                                                            double rotation_rate) {
  const PeriodKeeper::Follows how = periods_.follow(elements.stamp);
  if (how == PeriodKeeper::Follows::kNothing) {
    scaled_ = chained_ = settled_ = false;
    passes_ = 0;
  }
  if (how == PeriodKeeper::Follows::kAfterGap) breakChain();
  if (chain_.admit(elements, gains, rotation_rate) != BlockUse::kUsable) {
    periods_.spoil();
    breakChain();
  } else if (periods_.complete()) {
    gather();
  }
  if (!periods_.atLastBlock()) return std::nullopt;
  return finishPeriod();
}

double ExtendedIdentifier::restartSigma(double amplitude) const {
  // Wide enough that the mean of the period counts, not one sample.
  return 0.01 * amplitude + 10.0 * sample_sigma_;
}

void ExtendedIdentifier::gather() {
  const BlockChain::Block& now = chain_.last();
  const bool first_of_period = periods_.atFirstBlock();
  if (first_of_period) first_look_ = FirstLookSum();
  periods_.see(now.orbit.theta);
  if (!scaled_) {
    first_look_.add(now.orbit, now.drive, now.reference_frequency);
    return;
  }
  const Eigen::Vector4d measured = realParts(envelopeFromOrbit(now.orbit));
  const bool restarted = first_of_period && !chained_;
  if (restarted) filter_.restartEnvelope(measured, restartSigma(now.orbit.a));
  if (first_of_period) {
    update_blocks_ = updateBlocks();
    by_blocks_ = !filter_.isLinearOver(static_cast<double>(periodBlocks()) * block_duration_,
                                       static_cast<int>(periodBlocks()), inputOf(now));
  }
  if (!restarted) propagate();
  filter_.sample(measured);
  if (by_blocks_ || periods_.atLastBlock() ||
      (periods_.blockOfPeriod() + 1) % update_blocks_ == 0) {
    update_ = filter_.update();
    chained_ = update_.accepted;
    if (!update_.accepted) periods_.spoil();
  }
}

/// Number of blocks whose mean is one update. While the envelope turns or decays much, a mean shows
/// little of it, so that the mean must be short.
std::uint64_t ExtendedIdentifier::updateBlocks() const {
  const ExtendedVector& value = filter_.value();
  const ExtendedState::Layout& at = state_.layout();
  const double rate = state_.decayRate(value) +
                      0.5 * state_.angularFrequency(value) * value.segment<2>(at.mu).norm();
  const double period = static_cast<double>(periodBlocks()) * block_duration_;
  const double parts = std::ceil(rate * period / kMostTurn);
  const double blocks = std::floor(static_cast<double>(periodBlocks()) / std::max(parts, 1.0));
  return static_cast<std::uint64_t>(std::max(blocks, 1.0));
}

void ExtendedIdentifier::propagate() {
  const Eigen::Vector4d measured_before = realParts(envelopeFromOrbit(chain_.before().orbit));
  const Eigen::Vector4d measured_change =
      realParts(envelopeFromOrbit(chain_.last().orbit)) - measured_before;
  for (const ChainSegment& segment : chain_.segments()) {
    if (segment.duration <= 0.0) continue;
    filter_.step(segment.input, measured_before + segment.middle * measured_change,
                 segment.duration);
  }
}

void ExtendedIdentifier::breakChain() {
  if (chained_) {
    const Eigen::Vector4d envelope = filter_.value().head<4>();
    filter_.restartEnvelope(envelope, restartSigma(envelope.norm()));
  }
  chained_ = false;
}

ExtendedEstimate ExtendedIdentifier::finishPeriod() {
  const BlockStamp& stamp = periods_.last();
  ExtendedEstimate estimate;
  bool used = false;
  if (periods_.complete() && scaled_) {
    reconsider();
    used = estimate.updated = true;
    estimate.innovation = update_.innovation;
    estimate.innovation_covariance = update_.innovation_covariance;
    estimate.normalised_innovation_squared = update_.normalised_innovation_squared;
    estimate.whole_period = !by_blocks_;
  } else if (periods_.complete()) {
    used = setScale();
  }
  periods_.finish(used);

  estimate.stamp = stamp;
  estimate.used_blocks = periods_.used();
  estimate.rejected_blocks = periods_.rejected();
  estimate.lost_blocks = periods_.lost();
  estimate.scaled = scaled_;
  estimate.settled = scaled_ && settled_;
  estimate.angle_covered = periods_.angleCovered();
  estimate.value.setZero(state_.size());
  estimate.covariance.setZero(state_.size(), state_.size());
  if (!scaled_) return estimate;
  const ExtendedVector& linear = filter_.value();
  const ExtendedMatrix slope = state_.physicalByLinear(linear);
  estimate.value = state_.physical(linear);
  const ExtendedMatrix covariance = slope * filter_.covariance() * slope.transpose();
  estimate.covariance = 0.5 * (covariance + covariance.transpose());
  estimate.quality_factor = 0.5 * state_.angularFrequency(linear) / state_.decayRate(linear);
  return estimate;
}

void ExtendedIdentifier::reconsider() {
  if (filter_.linearisesAtEstimate()) return;
  const ExtendedVector& value = filter_.value();
  const int cubic = state_.layout().pickoff_cubic;
  double cubic_sigma = 0.0;
  double cubic_moved = 0.0;
  if (cubic >= 0) {
    const double square_amplitude = value.head<4>().squaredNorm();
    cubic_sigma = square_amplitude * std::sqrt(filter_.covariance()(cubic, cubic));
    cubic_moved = square_amplitude * std::abs(value[cubic] - cubic_at_start_);
  }
  const EnvelopeInput input = inputOf(chain_.last());
  const bool sharp = filter_.matrixSigma(input) < kMatrixSharp * state_.decayRate(value);
  if (settled_) {
    if (sharp && cubic_sigma < kCubicSharp) filter_.lineariseAtEstimate();
    return;
  }
  if (++periods_of_pass_ < kLeastPeriods) return;
  if (passes_ > 0 && (!sharp || cubic_sigma > kCubicFound)) return;
  const bool near = filter_.matrixMoved(input) < kMatrixNear * state_.decayRate(value);
  settled_ = passes_ > 0 && near && cubic_moved < kCubicOff;
  ++passes_;
  if (!settled_) startAgain();
}

/// Starts the next pass. The parameters get the prior before any data again, so that no data count
/// twice; only mu and f0, whose prior is very wide, keep what was found. The pass is linearised at
/// the parameters that were found, and at the start values of the others.
void ExtendedIdentifier::startAgain() {
  const ExtendedState::Layout& at = state_.layout();
  const ExtendedVector found = state_.physical(filter_.value());
  const ExtendedMatrix slope = state_.physicalByLinear(filter_.value());
  const ExtendedVector found_sigma =
      (slope * filter_.covariance() * slope.transpose()).diagonal().cwiseSqrt();
  ExtendedVector value = first_value_;
  ExtendedVector sigma = first_sigma_;
  const auto keep = [&](int state) {
    if (state < 0) return;
    value[state] = found[state];
    sigma[state] = std::min(sigma[state], kWidening * found_sigma[state]);
  };
  keep(at.mu);
  keep(at.mu + 1);
  keep(at.frequency);
  ExtendedVector nominal = value;
  for (Eigen::Index k = 4; k < nominal.size(); ++k) {
    if (found_sigma[k] < kFoundShare * first_sigma_[k]) nominal[k] = found[k];
  }
  value.head<4>() = found.head<4>();
  start(value, sigma, nominal);
}

bool ExtendedIdentifier::setScale() {
  const FirstLook look = first_look_.look(block_duration_, state_.device().decayRate());
  ExtendedVector value = startValue(state_, parameters_, look);
  const double drive_gain = value[state_.layout().drive_gain];
  if (!(look.drive_gain > 0.0) || !std::isfinite(drive_gain)) return false;
  value.head<4>() = realParts(envelopeFromOrbit(chain_.last().orbit));
  first_value_ = value;
  first_sigma_ = priorSigma(state_, parameters_, value);
  first_sigma_.head<4>().setConstant(restartSigma(value.head<4>().norm()));
  start(value, first_sigma_, value);
  return true;
}

void ExtendedIdentifier::start(const ExtendedVector& value, const ExtendedVector& sigma,
                               const ExtendedVector& nominal) {
  const ExtendedMatrix slope = state_.linearByPhysical(value);
  const ExtendedMatrix prior = slope * sigma.cwiseAbs2().asDiagonal() * slope.transpose();
  ExtendedVector scale = slope.cwiseAbs() * sigma;
  scale.head<4>().setOnes();
  ExtendedVector growth = slope.cwiseAbs2() * parameterWalk(state_, parameters_, value).cwiseAbs2();
  growth.head<4>().setZero();
  filter_.initialise(state_.linear(value), prior, scale, growth);
  scaled_ = true;
  chained_ = false;
  periods_of_pass_ = 0;
  const int cubic = state_.layout().pickoff_cubic;
  if (cubic >= 0) cubic_at_start_ = nominal[cubic];
  filter_.linearise(state_.linear(nominal));
}

}  // namespace cvg
