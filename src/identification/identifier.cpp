#include "ring_gyro/identification/identifier.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <variant>

namespace ring_gyro {
namespace {

// Variance of what nothing is known of yet: finite, so that it can be sent and plotted.
constexpr double kUnknownVariance = 1e30;
// Section 6 of the paper, in the order of (29), for one update a period. With such noise the model
// is never linear over a period: it is spread over the updates of the period's blocks.
constexpr std::array<double, 7> kPaperProcessNoise = {1e-4, 1e-4, 1.0, 1.0, 1e-2, 1e-2, 1e7};
constexpr double kPaperMeasurementNoise = 1e-4;

const IdentificationParameters& checked(const IdentificationParameters& parameters) {
  IdentificationParameters copy = parameters;
  ParameterTable table;
  copy.declare(table);
  for (const Parameter& parameter : table.parameters()) {
    if (const auto* number = std::get_if<double*>(&parameter.target)) {
      if (!parameter.range.contains(**number)) {
        throw std::invalid_argument("identification: " + parameter.key + " = " +
                                    std::to_string(**number) + " must be " +
                                    parameter.range.text());
      }
    }
  }
  if (parameters.tuning != "derived" && parameters.tuning != "paper") {
    throw std::invalid_argument("identification: tuning = " + parameters.tuning +
                                " must be derived or paper");
  }
  return parameters;
}

std::int64_t periodBlocks(const IdentificationParameters& parameters,
                          const ConverterParameters& converter) {
  const double blocks = parameters.update_period / converter.blockDuration();
  const double whole = std::round(blocks);
  if (whole < 1.0 || std::abs(blocks - whole) > 1e-6) {
    throw std::invalid_argument(
        "identification: update_period = " + std::to_string(parameters.update_period) +
        " s must be a whole number of blocks of " + std::to_string(converter.blockDuration()) +
        " s");
  }
  return static_cast<std::int64_t>(whole);
}

double square(double x) { return x * x; }

IntervalNoise intervalNoise(const IdentificationParameters& parameters, double block_duration,
                            std::int64_t period_blocks) {
  IntervalNoise noise;
  if (parameters.tuning == "paper") {
    const double blocks = static_cast<double>(period_blocks);
    noise.sample_variance = kPaperMeasurementNoise * blocks;
    noise.axes_density = kPaperProcessNoise[kA] / (blocks * block_duration);
  } else {
    // Demodulation gives each quadrature the two-sided density N^2; the moving average in it makes
    // samples of that variance over the block.
    const double density = square(parameters.noise_density);
    noise.sample_variance = density / block_duration;
    noise.axes_density = square(parameters.axis_process_noise);
    noise.angle_density = density;
  }
  return noise;
}

/// Finite, an ellipse, and not so large that a square could overflow later.
bool plausible(const OrbitalElements& elements, const ControlGains& gains) {
  constexpr double kLimit = 1e12;
  const auto within = [](double x) { return std::abs(x) < kLimit; };  // false for NaN
  const Orbit& orbit = elements.orbit;
  const Eigen::Vector2cd drive = gains.drive.total();
  return within(orbit.a) && within(orbit.b) && within(orbit.theta) && within(orbit.phi) &&
         std::abs(orbit.b) < orbit.a && std::isfinite(elements.group_delay) &&
         within(drive.x().real()) && within(drive.x().imag()) && within(drive.y().real()) &&
         within(drive.y().imag()) && within(gains.reference_phase) &&
         within(gains.reference_frequency) && gains.reference_frequency > 0.0 &&
         within(gains.compensation.gain1) && within(gains.compensation.gain2);
}

}  // namespace

void IdentificationParameters::declare(ParameterTable& table) {
  table
      .number("update_period", update_period, "s", Range::between(1e-6, 10.0),
              "a whole number of blocks; their mean is one measurement")
      .text("tuning", tuning, {"derived", "paper"},
            "noise of the filter: derived from the figures below, or the Q and R of the paper")
      .number("noise_density", noise_density, "V/sqrt(Hz)", Range::between(1e-12, 1.0),
              "of the displacement samples, white, one-sided")
      .number("axis_process_noise", axis_process_noise, "V/sqrt(s)", Range::between(0.0, 1.0),
              "what the averaged model does not know of a' and b', white")
      .number("initial_gamma_sigma", initial_gamma_sigma, "1", Range::between(1e-9, 1.0),
              "of gamma1 and gamma2 before any data")
      .number("initial_mu_sigma", initial_mu_sigma, "1", Range::between(1e-12, 1e-2),
              "of mu1 and mu2 before any data")
      .number("initial_drive_gain_sigma", initial_drive_gain_sigma, "1", Range::between(1e-9, 10.0),
              "of ks, relative to its value from the first period")
      .number("gamma_walk", gamma_walk, "1/sqrt(s)", Range::between(0.0, 1.0),
              "random walk of gamma1 and gamma2; 0: constant")
      .number("mu_walk", mu_walk, "1/sqrt(s)", Range::between(0.0, 1e-2),
              "random walk of mu1 and mu2; 0: constant")
      .number("drive_gain_walk", drive_gain_walk, "1/sqrt(s)", Range::between(0.0, 1.0),
              "random walk of ks, relative; 0: constant")
      .number("memory_time", memory_time, "s", Range::atLeast(0.0),
              "after which data count for 1/e, as far as newer data show the same; 0: for ever")
      .number("converged_gamma_sigma", converged_gamma_sigma, "1", Range::above(0.0),
              "converged needs both sigmas of gamma below this")
      .number("converged_mu_sigma", converged_mu_sigma, "1", Range::above(0.0),
              "converged needs both sigmas of mu below this")
      .number("converged_drive_gain_sigma", converged_drive_gain_sigma, "1", Range::above(0.0),
              "converged needs the sigma of ks, relative to ks, below this")
      .number("converged_angle", converged_angle, "rad", Range::atLeast(0.0),
              "converged needs at least this span of theta in the data used");
}

Identifier::Identifier(const IdentificationParameters& parameters,
                       const ConverterParameters& converter)
    : parameters_(checked(parameters)),
      model_(parameters.natural_frequency, parameters.quality_factor),
      filter_(model_, intervalNoise(parameters, converter.blockDuration(),
                                    ring_gyro::periodBlocks(parameters, converter))),
      period_blocks_(ring_gyro::periodBlocks(parameters, converter)),
      period_(static_cast<double>(period_blocks_) * converter.blockDuration()),
      block_duration_ns_(converter.blockDurationNanoseconds()),
      sample_sigma_(parameters.noise_density / std::sqrt(converter.blockDuration())) {}

const ParameterEstimate* Identifier::process(const OrbitalElements& elements,
                                             const ControlGains& gains) {
  const BlockStamp& stamp = elements.stamp;
  if (!started_ || stamp.session != last_stamp_.session || stamp.sequence <= last_stamp_.sequence) {
    restart(stamp);
  } else if (stamp.sequence != last_stamp_.sequence + 1) {
    skipLost(stamp);
  }

  const auto period_blocks = static_cast<std::uint64_t>(period_blocks_);
  const bool first_of_period = stamp.sequence % period_blocks == 0;
  if (first_of_period) {
    blocks_in_period_ = 0;
    complete_ = true;
  }
  ++blocks_in_period_;

  const bool admitted = admit(elements, gains);
  last_stamp_ = stamp;
  if (!admitted) {
    breakChain();
  } else if (complete_) {
    gather(stamp.sequence, stamp.duration(), first_of_period);
  }
  if ((stamp.sequence + 1) % period_blocks != 0) return nullptr;
  finishPeriod(stamp, gains.compensation);
  return &estimate_;
}

void Identifier::restart(const BlockStamp& stamp) {
  if (started_) ++restarts_;
  started_ = true;
  first_sequence_ = stamp.sequence;
  used_ = rejected_ = lost_ = 0;
  usable_run_ = 0;
  scaled_ = chained_ = complete_ = false;
  blocks_in_period_ = 0;
  lowest_theta_ = highest_theta_ = 0.0;
}

void Identifier::skipLost(const BlockStamp& stamp) {
  lost_ += stamp.sequence - last_stamp_.sequence - 1;
  const auto period_blocks = static_cast<std::uint64_t>(period_blocks_);
  if (stamp.sequence / period_blocks != last_stamp_.sequence / period_blocks &&
      (last_stamp_.sequence + 1) % period_blocks != 0) {
    rejected_ += blocks_in_period_;  // of a period whose end was lost
    blocks_in_period_ = 0;
  }
  usable_run_ = 0;
  breakChain();
}

/// Remembers the block when it can be used; true when all that its elements depend on can be too.
bool Identifier::admit(const OrbitalElements& elements, const ControlGains& gains) {
  const BlockStamp& stamp = elements.stamp;
  const bool paired =
      gains.stamp.session == stamp.session && gains.stamp.sequence == stamp.sequence;
  const bool timed = stamp.end_ns > 0 && stamp.duration_ns == block_duration_ns_;
  const bool usable = paired && timed && elements.status.usable() && gains.status.usable() &&
                      plausible(elements, gains);
  if (!usable) {
    usable_run_ = 0;
    return false;
  }
  const bool follows = usable_run_ > 0 && stamp.sequence == last_stamp_.sequence + 1 &&
                       stamp.end_ns - last_stamp_.end_ns == block_duration_ns_ &&
                       elements.group_delay == group_delay_;
  if (!follows) {
    usable_run_ = 0;
    if (!setDelay(elements.group_delay, stamp.duration())) return false;
  }
  memory_[stamp.sequence % kMemory] = {elements.orbit, gains.drive.total(), gains.reference_phase,
                                       gains.reference_frequency};
  ++usable_run_;
  return usable_run_ >= filter_memory_;
}

bool Identifier::setDelay(double group_delay, double duration) {
  const double blocks = group_delay / duration;
  if (!(blocks >= 0.0) || 2.0 * blocks + 2.0 > static_cast<double>(kMemory)) return false;
  // A delay of whole blocks up to rounding has no rest.
  const double whole = std::floor(blocks + 1e-9);
  group_delay_ = group_delay;
  whole_delay_ = static_cast<std::uint64_t>(whole);
  rest_of_delay_ = blocks - whole > 1e-9 ? blocks - whole : 0.0;
  filter_memory_ =
      std::max<std::uint64_t>(1, static_cast<std::uint64_t>(std::ceil(2.0 * blocks - 1e-9)));
  return true;
}

void Identifier::gather(std::uint64_t sequence, double duration, bool first_of_period) {
  const Block& now = block(sequence);
  if (first_of_period) {
    lowest_theta_in_period_ = highest_theta_in_period_ = now.orbit.theta;
    amplitude_sum_ = frequency_sum_ = drive_sum_ = 0.0;
  }
  lowest_theta_in_period_ = std::min(lowest_theta_in_period_, now.orbit.theta);
  highest_theta_in_period_ = std::max(highest_theta_in_period_, now.orbit.theta);

  if (!scaled_) {
    const std::complex<double> along =
        std::cos(now.orbit.theta) * now.drive.x() + std::sin(now.orbit.theta) * now.drive.y();
    amplitude_sum_ += now.orbit.a;
    frequency_sum_ += now.reference_frequency;
    drive_sum_ += (std::polar(1.0, -now.orbit.phi) * along).imag();
    return;
  }
  const Eigen::Vector2d axes(now.orbit.a, now.orbit.b);
  const bool restarted = first_of_period && !chained_;
  // Wide enough that the period's mean decides, and not this one sample.
  if (restarted) filter_.restartAxes(axes, 0.01 * now.orbit.a + 10.0 * sample_sigma_);
  if (first_of_period) {
    by_blocks_ =
        period_blocks_ == 1 ||
        !filter_.isLinearOver(period_, static_cast<int>(period_blocks_), now.reference_frequency);
  }
  if (!restarted) {
    propagate(sequence, duration);
  }
  filter_.sample(axes);
  const auto period_blocks = static_cast<std::uint64_t>(period_blocks_);
  if (by_blocks_ || (sequence + 1) % period_blocks == 0) {
    update_ = filter_.update();
    chained_ = update_.accepted;
    if (!update_.accepted) breakChain();
  }
}

/// From where the elements of the block before are valid to where those of this block are. Both
/// moments lie the rest of the delay before the end of a block; drive and frequency change in
/// between.
///
/// One step takes both drives to second order: their means are those that a response which decays
/// meets at the end of the step, for which what is late counts more, and a change of drive late in
/// the step meets a pattern that has turned on.
void Identifier::propagate(std::uint64_t sequence, double duration) {
  const Block& before = block(sequence - 1);
  const Block& now = block(sequence);
  const Block& acted_first = block(sequence - 1 - whole_delay_);
  const Block& acted_then = block(sequence - whole_delay_);
  const double theta_change = now.orbit.theta - before.orbit.theta;
  const double phi_change = now.orbit.phi - before.orbit.phi;
  const double decay = model_.decayRate() * duration;
  const double middle = 0.5 + decay / 12.0;  // of the weights e^(-decay (1 - s)), 0 <= s <= 1
  const double share = rest_of_delay_;
  const double moment = 0.5 * share * (1.0 - share);  // of a unit step about the middle
  const double first = share - moment * decay;
  const double then = 1.0 - first;

  AveragedInput input;
  input.pattern_rate = theta_change / duration;
  input.reference_frequency =
      first * acted_first.reference_frequency + then * acted_then.reference_frequency;
  // A drive acts in proportion to 1 / w, and less by a sinc where the pattern turns away under it.
  const double scale = (1.0 - theta_change * theta_change / 24.0) * input.reference_frequency;
  const double first_scale = first * scale / acted_first.reference_frequency;
  const double then_scale = then * scale / acted_then.reference_frequency;
  const Eigen::Vector2cd late = moment * (acted_then.drive - acted_first.drive);
  // Turning the pattern turns Fx into Fy and Fy into -Fx; turning phi multiplies both by -i.
  const auto turned = [&](const std::complex<double>& along, const std::complex<double>& across) {
    return std::complex<double>(theta_change * across.real() + phi_change * along.imag(),
                                theta_change * across.imag() - phi_change * along.real());
  };
  input.drive = first_scale * acted_first.drive + then_scale * acted_then.drive +
                driveStep(acted_first.drive, acted_then.drive, acted_then.reference_phase,
                          acted_then.reference_frequency, duration);
  input.drive.x() += turned(late.x(), late.y());
  input.drive.y() += turned(late.y(), -late.x());
  filter_.step(before.orbit.theta + middle * theta_change, before.orbit.phi + middle * phi_change,
               input, duration);
}

void Identifier::breakChain() {
  complete_ = false;
  if (chained_) {
    const Eigen::Vector2d axes = filter_.value().head<2>();
    filter_.restartAxes(axes, 0.01 * std::abs(axes[0]) + 10.0 * sample_sigma_);
  }
  chained_ = false;
}

void Identifier::finishPeriod(const BlockStamp& stamp, const DampingCompensation& compensation) {
  ParameterEstimate& estimate = estimate_;
  bool used = false;
  estimate.updated = complete_ && scaled_;
  if (estimate.updated) {
    used = true;
    estimate.innovation = update_.innovation;
    estimate.innovation_covariance = update_.innovation_covariance;
    estimate.normalised_innovation_squared = update_.normalised_innovation_squared;
  } else {
    estimate.innovation.setZero();
    estimate.innovation_covariance.setZero();
    estimate.normalised_innovation_squared = 0.0;
    used = complete_ && setScale();
  }
  if (used) {
    const bool first = used_ == 0;
    lowest_theta_ =
        first ? lowest_theta_in_period_ : std::min(lowest_theta_, lowest_theta_in_period_);
    highest_theta_ =
        first ? highest_theta_in_period_ : std::max(highest_theta_, highest_theta_in_period_);
  }
  (used ? used_ : rejected_) += blocks_in_period_;
  blocks_in_period_ = 0;
  complete_ = false;

  estimate.stamp = stamp;
  estimate.first_sequence = first_sequence_;
  estimate.used_blocks = used_;
  estimate.rejected_blocks = rejected_;
  estimate.lost_blocks = lost_;
  estimate.angle_covered = highest_theta_ - lowest_theta_;
  if (scaled_) {
    estimate.value = filter_.value();
    estimate.covariance = filter_.covariance();
  } else {
    estimate.value.setZero();
    estimate.covariance.setZero();
    estimate.covariance.diagonal() << kUnknownVariance, kUnknownVariance,
        square(parameters_.initial_gamma_sigma), square(parameters_.initial_gamma_sigma),
        square(parameters_.initial_mu_sigma), square(parameters_.initial_mu_sigma),
        kUnknownVariance;
  }
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
  const double blocks = static_cast<double>(period_blocks_);
  const double drive_gain =
      2.0 * (frequency_sum_ / blocks) * model_.decayRate() * amplitude_sum_ / drive_sum_;
  if (!(drive_sum_ > 0.0) || !std::isfinite(drive_gain)) return false;

  StateVector value = StateVector::Zero();
  value[kA] = amplitude_sum_ / blocks;
  value[kDriveGain] = drive_gain;
  const double axis_sigma = 0.01 * value[kA] + 10.0 * sample_sigma_;
  StateVector sigma;
  sigma << axis_sigma, axis_sigma, parameters_.initial_gamma_sigma, parameters_.initial_gamma_sigma,
      parameters_.initial_mu_sigma, parameters_.initial_mu_sigma,
      parameters_.initial_drive_gain_sigma * drive_gain;
  IntervalFilter::ParameterVector walk;
  if (parameters_.tuning == "paper") {
    for (int k = 0; k < 5; ++k) walk[k] = std::sqrt(kPaperProcessNoise[k + 2] / period_);
  } else {
    walk << parameters_.gamma_walk, parameters_.gamma_walk, parameters_.mu_walk,
        parameters_.mu_walk, parameters_.drive_gain_walk * drive_gain;
  }
  filter_.initialise(value, sigma, walk, parameters_.memory_time);
  scaled_ = true;
  return true;
}

bool Identifier::converged() const {
  const ParameterEstimate& estimate = estimate_;
  return scaled_ && estimate.sigma(kGamma1) < parameters_.converged_gamma_sigma &&
         estimate.sigma(kGamma2) < parameters_.converged_gamma_sigma &&
         estimate.sigma(kMu1) < parameters_.converged_mu_sigma &&
         estimate.sigma(kMu2) < parameters_.converged_mu_sigma &&
         estimate.sigma(kDriveGain) <
             parameters_.converged_drive_gain_sigma * std::abs(estimate.value[kDriveGain]) &&
         estimate.angle_covered >= parameters_.converged_angle;
}

}  // namespace ring_gyro
