#include "ring_gyro/identification/filter/interval_filter.h"

#include <cmath>

#include "ring_gyro/common/vector_dispatch.h"

namespace cvg {
namespace {

TwoLanes pairOf(const Eigen::Vector2d& vector) { return TwoLanes{vector[0], vector[1]}; }

/// Written as Eigen reads it (pairs.h).
StateVector stateOf(const TwoLanes& axes, const ParameterLanes& parameters) {
  StateVector state;
  store(axes, state.data());
  store(parameters.mismatch, state.data() + 2);
  state[6] = parameters.drive_gain;
  return state;
}

/// Of the two components of the drive that bring noise of the angles into a' and b': sum of squares
/// and product.
TwoLanes squaresOf(const AxesDynamics<double>& dynamics) {
  return TwoLanes{dynamics.along_real * dynamics.along_real +
                      dynamics.across_imaginary * dynamics.across_imaginary,
                  dynamics.along_real * dynamics.across_imaginary};
}

}  // namespace

IntervalFilter::IntervalFilter(const AveragedModel& model, const IntervalNoise& noise)
    : model_(model), noise_(noise) {
  initialise(StateVector::Zero(), StateVector::Zero(), ParameterVector::Zero());
}

void IntervalFilter::initialise(const StateVector& value, const StateVector& sigma,
                                const ParameterVector& walk, double memory_time) {
  drive_gain_scale_ = value[kDriveGain];
  Belief& belief = beliefs_[present_];
  belief.axes = pairOf(value.head<2>());
  belief.parameters = ParameterLanes(value.tail<5>());
  belief.covariance = FactoredCovariance(ParameterVector(sigma.tail<5>().cwiseAbs2()));
  belief.regression = {};
  belief.conditional = diagonal(sigma[kA] * sigma[kA], sigma[kB] * sigma[kB]);
  variance_growth_ = walk.cwiseAbs2();
  walks_ = !variance_growth_.isZero(0.0);
  memory_time_ = memory_time;
  abandon();
}

void IntervalFilter::restartAxes(const Eigen::Vector2d& axes, double sigma) {
  Belief& belief = beliefs_[present_];
  belief.axes = pairOf(axes);
  belief.regression = {};
  belief.conditional = diagonal(sigma * sigma, sigma * sigma);
  abandon();
}

void IntervalFilter::abandon() {
  axes_ = present().axes;
  elapsed_ = 0.0;
  samples_ = 0;
}

inline DeviceParameters IntervalFilter::device() const {
  const FourLanes& mismatch = present().parameters.mismatch;
  return {mismatch[0], mismatch[1], mismatch[2], mismatch[3], present().parameters.drive_gain};
}

bool IntervalFilter::isLinearOver(double duration, int samples, double reference_frequency) const {
  const StateVector variances = variance();
  const auto sigma = [&variances](int state) { return std::sqrt(variances[state]); };
  const double decay = model_.decayRate();
  const double gamma = decay * std::hypot(sigma(kGamma1), sigma(kGamma2));
  const double mu = 0.5 * reference_frequency * std::hypot(sigma(kMu1), sigma(kMu2));
  const double force = decay * sigma(kDriveGain) / std::abs(drive_gain_scale_);
  // The axes are off by what they are off now and by what they gather on the way; the uncertain
  // rates act on that error.
  const double gathered = 0.5 * (gamma + mu + force) * duration * std::hypot(axes_[0], axes_[1]);
  const double axes = std::hypot(sigma(kA), sigma(kB)) + gathered;
  const double neglected = axes * (gamma + mu) * duration;
  return neglected < 0.1 * std::sqrt(noise_.sample_variance / samples);
}

void IntervalFilter::sample(const Eigen::Vector2d& measured) {
  start();
  sensitivity_sum_ = sensitivity_;
  predicted_sum_ = axes_;
  measured_sum_ = pairOf(measured);
  samples_ = 1;
}

RING_GYRO_NOT_INLINE RING_GYRO_FLATTEN void IntervalFilter::step(const AveragedStep<double>& step,
                                                                 double duration,
                                                                 const Eigen::Vector2d& measured) {
  if (samples_ == 0) start();
  const AxesDynamics<double> dynamics(model_.decayRate(), model_.angularFrequency(), step);
  axes_ = advance(dynamics, squaresOf(dynamics), 1, duration);
  predicted_sum_ += axes_;
  measured_sum_ += pairOf(measured);
}

RING_GYRO_VECTOR_CLONES RING_GYRO_FLATTEN void IntervalFilter::steps(
    const AveragedStep<Lanes>& steps, int count, double duration, const Lanes& measured_a,
    const Lanes& measured_b) {
  if (samples_ == 0) start();
  const AxesDynamics<Lanes> dynamics(model_.decayRate(), model_.angularFrequency(), steps);
  const AxesTransition<Lanes> each = dynamics.transition(device(), duration);
  const Lanes a_kept = 1.0 + each.aa;
  const Lanes b_kept = 1.0 + each.bb;
  double a = axes_[0], b = axes_[1];
  double a_predicted = 0.0, b_predicted = 0.0;
// Short code counts: it is run once in several blocks, and then comes from far.
#pragma GCC unroll 1
  for (int k = 0; k < count; ++k) {
    // In this order a step waits for as little as can be of the one before.
    const double a_before = a;
    a = a_kept[k] * a + (each.ab[k] * b + each.a_force[k]);
    b = b_kept[k] * b + (each.ba[k] * a_before + each.b_force[k]);
    a_predicted += a;
    b_predicted += b;
  }

  using Whole = WholeLanes<Lanes>::Type;
  const Whole counted = Whole{0, 1, 2, 3, 4, 5, 6, 7} < Whole{} + static_cast<std::uint64_t>(count);
  const auto sum = [&counted](const Lanes& lanes) {
    return sumOf((Lanes)((Whole)lanes & counted));
  };
  const double share = 1.0 / count;
  const auto mean = [&](const Lanes& lanes) { return share * sum(lanes); };
  const TwoLanes mean_squares = {mean(dynamics.along_real * dynamics.along_real +
                                      dynamics.across_imaginary * dynamics.across_imaginary),
                                 mean(dynamics.along_real * dynamics.across_imaginary)};
  advance(AxesDynamics<double>(dynamics, mean), mean_squares, count, duration);
  axes_ = TwoLanes{a, b};
  predicted_sum_ += TwoLanes{a_predicted, b_predicted};
  measured_sum_ += TwoLanes{sum(measured_a), sum(measured_b)};
}

void IntervalFilter::start() {
  sensitivity_ = sensitivity_sum_ = Sensitivity();
  sensitivity_.by_axes = diagonal(1.0, 1.0);
  noise_end_ = noise_end_sum_ = noise_sum_ = Square();
  predicted_sum_ = measured_sum_ = TwoLanes{};
}

/// What noise in the angles, held for `duration`, is worth as a variance of a rate's integral, per
/// square of the rate's slope.
inline double IntervalFilter::angleVariance(const TwoLanes& axes, double duration) const {
  return duration * noise_.angle_density / (axes[0] * axes[0] + axes[1] * axes[1]);
}

/// Process noise of a and b in one of the steps of `duration` that `step` is made of.
inline Square IntervalFilter::stepNoise(const AxesStepPairs& step, const TwoLanes& axes,
                                        double duration) const {
  const double angle_variance = angleVariance(axes, duration);
  const double density = duration * noise_.axes_density;
  return angle_variance * (outer(step.rate_by_angles.first, step.rate_by_angles.first) +
                           outer(step.rate_by_angles.second, step.rate_by_angles.second)) +
         diagonal(density, density);
}

/// Derivatives and noise of the interval after `count` steps more from axes_ on, with these means
/// of their dynamics and of squaresOf() them. Within the steps the derivatives change in proportion
/// to time. Gives the axes to which one step over all of them leads.
RING_GYRO_FUSED_CLONES RING_GYRO_FLATTEN TwoLanes IntervalFilter::advance(
    const AxesDynamics<double>& mean, const TwoLanes& squares, int count, double duration) {
  const DeviceParameters parameters = device();
  const double n = count;
  const AxesStepPairs step = AxesRatePairs(mean, parameters).step(axes_, n * duration);
  // Loops that follow noise make drives that differ from step to step: the mean of their squares is
  // more than the square of their mean.
  const TwoLanes spread = squares - squaresOf(mean);
  const double angle_variance =
      angleVariance(axes_, duration) * parameters.drive_gain * parameters.drive_gain;
  const Square noise = stepNoise(step, axes_, duration) +
                       angle_variance * Square{TwoLanes{spread[0], -2.0 * spread[1]},
                                               TwoLanes{-2.0 * spread[1], spread[0]}};
  const Square& transition = step.by_axes;
  elapsed_ += n * duration;
  samples_ += count;

  // What the start passes on to the sum of the samples.
  const Square to_sum = 0.5 * (n + 1.0) * transition + diagonal(0.5 * (n - 1.0), 0.5 * (n - 1.0));
  sensitivity_sum_.by_axes = sensitivity_sum_.by_axes + to_sum * sensitivity_.by_axes;
  sensitivity_.by_axes = transition * sensitivity_.by_axes;
  sensitivity_sum_.by_parameters = sensitivity_sum_.by_parameters +
                                   to_sum * sensitivity_.by_parameters +
                                   0.5 * (n + 1.0) * step.by_parameters;
  sensitivity_.by_parameters = transition * sensitivity_.by_parameters + step.by_parameters;
  gatherNoise(transition, to_sum, noise, n);
  return step.axes;
}

/// Noise that the interval gathers in `n` steps: `transition` and `to_sum` pass on what there was
/// to the end and to the sum of the samples, `noise` is that of each step.
inline void IntervalFilter::gatherNoise(const Square& transition, const Square& to_sum,
                                        const Square& noise, double n) {
  const Square start_with_sum = noise_end_ * transposed(to_sum);
  const Square sum_with_sum = to_sum * noise_end_sum_;
  noise_sum_ = noise_sum_ + (sum_with_sum + transposed(sum_with_sum)) + to_sum * start_with_sum;
  noise_end_sum_ = transition * (noise_end_sum_ + start_with_sum);
  noise_end_ = transition * (noise_end_ * transposed(transition));

  // Noise of each step goes on to the end and to the samples from its own on: how often, and
  // through how many steps on the mean, to first order in what they do.
  const Square moved = (1.0 / n) * ((transition - diagonal(1.0, 1.0)) * noise);
  const Square moved_back = transposed(moved);
  const auto passed = [&](double steps, double other_steps) {
    return noise + steps * moved + other_steps * moved_back;
  };
  const double left = n - 1.0;
  const double pairs = 0.5 * n * (n + 1.0);
  const double triples = pairs * (2.0 * n + 1.0) / 3.0;
  // Sum over m < n of m (m + 1)^2 / 2.
  const double through = n * left * (3.0 * n * left + 4.0 * (2.0 * n - 1.0) + 6.0) / 24.0;
  noise_end_ = noise_end_ + n * passed(0.5 * left, 0.5 * left);
  noise_end_sum_ = noise_end_sum_ + pairs * passed(2.0 / 3.0 * left, 1.0 / 3.0 * left);
  noise_sum_ = noise_sum_ + triples * passed(through / triples, through / triples);
}

RING_GYRO_NOT_INLINE const IntervalUpdate& IntervalFilter::update() {
  if (samples_ == 0) return update_ = {};
  measureMean(beliefs_[1 - present_]);
  keep(sensitivity_sum_.by_parameters);
  return update_;
}

RING_GYRO_FUSED_CLONES RING_GYRO_FLATTEN const IntervalUpdate& IntervalFilter::stepAndUpdate(
    const AveragedStep<double>& step, double duration, const Eigen::Vector2d& measured) {
  if (samples_ > 0) {
    this->step(step, duration, measured);
    return update();
  }
  const DeviceParameters parameters = device();
  const AxesDynamics<double> dynamics(model_.decayRate(), model_.angularFrequency(), step);
  const AxesStepPairs taken = AxesRatePairs(dynamics, parameters).step(axes_, duration);
  elapsed_ = duration;
  measureStep(taken, stepNoise(taken, axes_, duration), pairOf(measured) - taken.axes,
              beliefs_[1 - present_]);
  keep(taken.by_parameters);
  return update_;
}

/// What is measured of the axes tells of the parameters, on which it depends by `regression`, given
/// them with covariance `conditional`, noise and all. Gives what the parameters gain. Notes the
/// update, and whether the noise is one: inputs beyond all reason can make some that is not.
inline ParameterLanes IntervalFilter::measureParameters(const ParameterRows& regression,
                                                        const Square& conditional,
                                                        const TwoLanes& innovation,
                                                        FactoredCovariance& next) {
  const FactoredCovariance::Outcome outcome =
      present().covariance.measure(regression, conditional, innovation, next);
  store(innovation, update_.innovation.data());
  store(outcome.innovation_covariance.first, update_.innovation_covariance.data());
  store(outcome.innovation_covariance.second, update_.innovation_covariance.data() + 2);
  update_.normalised_innovation_squared = outcome.normalised_innovation_squared;
  update_.accepted = conditional.first[0] > 0.0 && determinant(conditional) > 0.0;
  return outcome.gained;
}

/// What the axes are to depend on the parameters by, after the start's state has been passed on.
inline ParameterRows IntervalFilter::passedOn(const Square& by_axes,
                                              const ParameterRows& by_parameters) const {
  return by_axes * present().regression + by_parameters;
}

/// The step's end is what is measured.
inline void IntervalFilter::measureStep(const AxesStepPairs& step, const Square& noise,
                                        const TwoLanes& innovation, Belief& next) {
  const ParameterRows regression = passedOn(step.by_axes, step.by_parameters);
  const Square known = step.by_axes * (present().conditional * transposed(step.by_axes)) + noise;
  const Square conditional = known + diagonal(noise_.sample_variance, noise_.sample_variance);
  const ParameterLanes gained =
      measureParameters(regression, conditional, innovation, next.covariance);

  // Of the axes given the parameters; the gain is 1 - rest.
  const Square rest = noise_.sample_variance * inverse(conditional);
  next.regression = rest * regression;
  next.parameters = present().parameters + gained;
  next.conditional = symmetric(known * rest);
  next.axes = (step.axes + (innovation - rest * innovation)) + product(next.regression, gained);
}

void IntervalFilter::measureMean(Belief& next) {
  const double share = 1.0 / samples_;
  const double variance = share * noise_.sample_variance;
  const Square& to_end = sensitivity_.by_axes;
  const Square to_mean = share * sensitivity_sum_.by_axes;
  const ParameterRows of_end = passedOn(to_end, sensitivity_.by_parameters);
  const ParameterRows of_mean = passedOn(to_mean, share * sensitivity_sum_.by_parameters);
  const Square cross_noise = share * noise_end_sum_;
  const Square mean_noise = share * share * noise_sum_ + diagonal(variance, variance);
  const Square start_with_mean = present().conditional * transposed(to_mean);
  const Square conditional = symmetric(to_mean * start_with_mean + mean_noise);
  const TwoLanes innovation = share * (measured_sum_ - predicted_sum_);
  const ParameterLanes gained =
      measureParameters(of_mean, conditional, innovation, next.covariance);

  // Of the axes given the parameters, as a sum of what cannot be negative (Joseph).
  const Square gain = (to_end * start_with_mean + cross_noise) * inverse(conditional);
  const Square rest = to_end - gain * to_mean;
  const Square mixed = gain * transposed(cross_noise);
  next.regression = of_end - gain * of_mean;
  next.parameters = present().parameters + gained;
  next.conditional =
      symmetric(rest * (present().conditional * transposed(rest)) + noise_end_ -
                (mixed + transposed(mixed)) + gain * (mean_noise * transposed(gain)));
  next.axes = (axes_ + gain * innovation) + product(next.regression, gained);
}

/// Makes the next belief the present one unless a number in it is not finite, and starts the next
/// interval. `shown`: what the measurement has shown of the parameters.
inline void IntervalFilter::keep(const ParameterRows& shown) {
  Belief& next = beliefs_[1 - present_];
  const ParameterLanes sum = next.parameters + (next.regression.first + next.regression.second);
  update_.accepted &= std::isfinite(
      sumOf(sum) + (next.axes[0] + next.axes[1]) +
      (next.conditional.first[0] + next.conditional.first[1] + next.conditional.second[1]) +
      (update_.innovation_covariance.sum() + update_.normalised_innovation_squared +
       next.covariance.sum()));
  update_.accepted &= next.conditional.first[0] >= 0.0 && next.conditional.second[1] >= 0.0;
  if (update_.accepted) {
    if (walks_) walk(next);
    if (memory_time_ > 0.0) forget(shown, next);
    present_ = 1 - present_;
  } else {
    update_ = {};
  }
  abandon();
}

RING_GYRO_NOT_INLINE void IntervalFilter::walk(Belief& belief) const {
  for (int k = 0; k < variance_growth_.size(); ++k) {
    addTo(belief, elapsed_ * variance_growth_[k], ParameterVector::Unit(k));
  }
}

/// Directional forgetting (Kulhavy): the covariance grows along P h, where the interval's
/// measurement h has just made it smaller, and nowhere else. What the data do not show, as with a
/// pattern at rest, stays as well known as it was.
RING_GYRO_NOT_INLINE void IntervalFilter::forget(const ParameterRows& shown, Belief& belief) const {
  const double growth = std::expm1(elapsed_ / memory_time_);
  for (const ParameterLanes& lanes : {shown.first, shown.second}) {
    const ParameterVector row = lanes.vector();
    const ParameterVector direction = belief.covariance.matrix() * row;
    const double variance = row.dot(direction);
    if (variance > 0.0) addTo(belief, growth / variance, direction);
  }
}

/// Adds weight * direction direction' to the covariance of the parameters.
void IntervalFilter::addTo(Belief& belief, double weight, const ParameterVector& direction) {
  const auto gained = belief.covariance.add(weight, direction, belief.regression);
  belief.conditional = belief.conditional + gained.weight * outer(gained.factor, gained.factor);
}

StateVector IntervalFilter::value() const { return stateOf(present().axes, present().parameters); }

StateMatrix IntervalFilter::covariance() const {
  const Eigen::Matrix<double, 2, 5> regression = present().regression.matrix();
  const FactoredCovariance::Matrix parameters = present().covariance.matrix();
  const Eigen::Matrix<double, 2, 5> cross = regression * parameters;
  StateMatrix result;
  result << cross * regression.transpose(), cross, cross.transpose(), parameters;
  result(kA, kB) += present().conditional.second[0];
  result(kB, kA) = result(kA, kB);
  result.diagonal() = variance();
  return result;
}

RING_GYRO_FUSED_CLONES RING_GYRO_FLATTEN ParameterVector IntervalFilter::parameterVariance() const {
  return present().covariance.variance().vector();
}

StateVector IntervalFilter::variance() const {
  const Belief& belief = present();
  const TwoLanes axes = belief.covariance.variance(belief.regression);
  StateVector result;
  result << belief.conditional.first[0] + axes[0], belief.conditional.second[1] + axes[1],
      parameterVariance();
  return result;
}

}  // namespace cvg
