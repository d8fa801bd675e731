#include "ring_gyro/identification/filter/interval_filter.h"

#include <algorithm>
#include <cmath>

#include "ring_gyro/common/vector_dispatch.h"

namespace cvg {
namespace {

StateVector stateOf(const Vector2& axes, const Vector5& parameters) {
  StateVector state;
  store(axes, state.data());
  store(parameters.mismatch, state.data() + 2);
  state[6] = parameters.drive_gain;
  return state;
}

/// Re f1 and Im f2, the two components of the drive through which noise of the angles acts on a'
/// and b': sum of their squares, and their product.
template <typename Real>
struct DriveSquares {
  Real sum, product;
  explicit DriveSquares(const AxesDynamics<Real>& at)
      : sum(at.f1.re * at.f1.re + at.f2.im * at.f2.im), product(at.f1.re * at.f2.im) {}
};

}  // namespace

IntervalFilter::IntervalFilter(const AveragedModel& model, const IntervalNoise& noise,
                               double step_duration)
    : model_(model), noise_(noise), step_duration_(step_duration) {
  initialise(StateVector::Zero(), StateVector::Zero(), ParameterVector::Zero());
}

void IntervalFilter::initialise(const StateVector& value, const StateVector& sigma,
                                const ParameterVector& walk, double memory_time) {
  drive_gain_scale_ = value[kDriveGain];
  Belief& belief = beliefs_[present_];
  belief.axes = vector2(value.head<2>());
  belief.parameters = Vector5(value.tail<5>());
  belief.covariance = FactoredCovariance(ParameterVector(sigma.tail<5>().cwiseAbs2()));
  belief.regression = {};
  belief.conditional = Matrix2::diagonal(sigma[kA] * sigma[kA], sigma[kB] * sigma[kB]);
  variance_growth_ = walk.cwiseAbs2();
  walks_ = !variance_growth_.isZero(0.0);
  memory_time_ = memory_time;
  abandon();
}

void IntervalFilter::restartAxes(const Eigen::Vector2d& axes, double sigma) {
  Belief& belief = beliefs_[present_];
  belief.axes = vector2(axes);
  belief.regression = {};
  belief.conditional = Matrix2::diagonal(sigma * sigma, sigma * sigma);
  abandon();
}

void IntervalFilter::abandon() {
  waiting_.clear();
  axes_ = present().axes;
  elapsed_ = 0.0;
  samples_ = 0;
}

inline DeviceParameters IntervalFilter::device() const {
  const FourLanes& mismatch = present().parameters.mismatch;
  return {mismatch[0], mismatch[1], mismatch[2], mismatch[3], present().parameters.drive_gain};
}

bool IntervalFilter::isLinearOver(int steps, double reference_frequency) const {
  const double duration = steps * step_duration_;
  const StateVector variances = variance();
  const auto sigma = [&variances](int state) { return std::sqrt(variances[state]); };
  const double decay = model_.decayRate();
  const double gamma = decay * std::hypot(sigma(kGamma1), sigma(kGamma2));
  const double mu = 0.5 * reference_frequency * std::hypot(sigma(kMu1), sigma(kMu2));
  const double force = decay * sigma(kDriveGain) / std::abs(drive_gain_scale_);
  // The error of the axes is their error now plus what it grows by on the way; the uncertain rates
  // act on it.
  const double gathered = 0.5 * (gamma + mu + force) * duration * std::hypot(axes_[0], axes_[1]);
  const double axes = std::hypot(sigma(kA), sigma(kB)) + gathered;
  const double neglected = axes * (gamma + mu) * duration;
  return neglected < 0.1 * std::sqrt(noise_.sample_variance / steps);
}

void IntervalFilter::sample(const Eigen::Vector2d& measured) {
  start();
  to_sum_ = to_end_;
  predicted_sum_ = axes_;
  measured_sum_ = vector2(measured);
  samples_ = 1;
}

void IntervalFilter::start() {
  to_end_ = to_sum_ = Sensitivity();
  to_end_.by_axes = Matrix2::diagonal(1.0, 1.0);
  gathered_ = Noise();
  predicted_sum_ = measured_sum_ = Vector2{};
}

void IntervalFilter::step(const AveragedStep<double>& step, const Eigen::Vector2d& measured) {
  waiting_.push(step, measured);
  if (waiting_.size() == StepQueue::kMost) settle();
}

RING_GYRO_VECTOR_CLONES RING_GYRO_FLATTEN void IntervalFilter::settle() {
  if (samples_ == 0) start();
  const int waiting = static_cast<int>(waiting_.size());
  for (int first = 0; first < waiting; first += static_cast<int>(kLanes)) {
    const StepQueue::Group& group = waiting_.group(static_cast<std::size_t>(first));
    const int count = std::min(static_cast<int>(kLanes), waiting - first);
    const AxesDynamics<Lanes> dynamics(model_.decayRate(), model_.angularFrequency(), group.step);
    const AxesTransition<Lanes> each = dynamics.transition(device(), step_duration_);
    const Lanes a_kept = 1.0 + each.change.aa;
    const Lanes b_kept = 1.0 + each.change.bb;
    double a = axes_[0], b = axes_[1];
    double a_predicted = 0.0, b_predicted = 0.0;
// Not unrolled: this code runs too seldom to stay in the instruction cache; short code is faster.
#pragma GCC unroll 1
    for (int k = 0; k < count; ++k) {
      // In this order of operations a step waits least for the result of the step before.
      const double a_before = a;
      a = a_kept[k] * a + (each.change.ab[k] * b + each.a_force[k]);
      b = b_kept[k] * b + (each.change.ba[k] * a_before + each.b_force[k]);
      a_predicted += a;
      b_predicted += b;
    }

    using Whole = WholeLanes<Lanes>::Type;
    const Whole counted =
        Whole{0, 1, 2, 3, 4, 5, 6, 7} < Whole{} + static_cast<std::uint64_t>(count);
    const auto sum = [&counted](const Lanes& lanes) {
      return sumOf((Lanes)((Whole)lanes & counted));
    };
    const double share = 1.0 / count;
    const auto mean = [&](const Lanes& lanes) { return share * sum(lanes); };
    const DriveSquares<Lanes> squares(dynamics);
    advance(AxesDynamics<double>(dynamics, mean), Vector2{mean(squares.sum), mean(squares.product)},
            count);
    axes_ = Vector2{a, b};
    predicted_sum_ += Vector2{a_predicted, b_predicted};
    measured_sum_ += Vector2{sum(group.a), sum(group.b)};
  }
  waiting_.clear();
}

/// Variance that noise of the angles, constant over a step, gives to the integral of a rate over
/// the step, for a derivative of 1 of the rate by the angle.
inline double IntervalFilter::angleVariance(const Vector2& axes) const {
  return step_duration_ * noise_.angle_density / (axes[0] * axes[0] + axes[1] * axes[1]);
}

/// Process noise of a and b in one of the steps of step_duration_ that `step` consists of.
inline Matrix2 IntervalFilter::stepNoise(const AxesStepResult& step, const Vector2& axes) const {
  return angleVariance(axes) * (outer(step.rate_by_angles.first, step.rate_by_angles.first) +
                                outer(step.rate_by_angles.second, step.rate_by_angles.second)) +
         step_duration_ * noise_.axes_density;
}

/// Carries the derivatives and the noise of the interval on by `count` steps that start at axes_;
/// `mean` and `squares` are the means of their dynamics and of their DriveSquares. Within these
/// steps the derivatives are taken to change in proportion to time. Returns the axes after one step
/// over all of them.
RING_GYRO_FUSED_CLONES RING_GYRO_FLATTEN Vector2
IntervalFilter::advance(const AxesDynamics<double>& mean, const Vector2& squares, int count) {
  const DeviceParameters parameters = device();
  const double n = count;
  const AxesStepResult step = AxesEquation(mean, parameters).step(axes_, n * step_duration_);
  // The loops follow noise, so the drive differs from step to step: the mean of the squares is more
  // than the square of the mean.
  const DriveSquares<double> of_mean(mean);
  const double more = squares[0] - of_mean.sum;
  const double more_across = -2.0 * (squares[1] - of_mean.product);
  const double ks = parameters.drive_gain;
  const Matrix2 noise =
      stepNoise(step, axes_) + angleVariance(axes_) * ks * ks *
                                   Matrix2{Vector2{more, more_across}, Vector2{more_across, more}};
  elapsed_ += n * step_duration_;
  samples_ += count;

  // The state where the steps begin acts through T on their end and through T_s on the sum of their
  // samples.
  const Matrix2& t = step.by_axes;
  const Matrix2 t_s = 0.5 * (n + 1.0) * t + 0.5 * (n - 1.0);
  to_sum_.by_axes = to_sum_.by_axes + t_s * to_end_.by_axes;
  to_end_.by_axes = t * to_end_.by_axes;
  to_sum_.by_parameters =
      to_sum_.by_parameters + t_s * to_end_.by_parameters + 0.5 * (n + 1.0) * step.by_parameters;
  to_end_.by_parameters = t * to_end_.by_parameters + step.by_parameters;
  gatherNoise(t, t_s, noise, n);
  return step.axes;
}

/// Adds the noise of `n` steps to the interval, each of which adds `noise` (docs/filter.md,
/// section 4).
inline void IntervalFilter::gatherNoise(const Matrix2& t, const Matrix2& t_s, const Matrix2& noise,
                                        double n) {
  // The noise gathered so far is passed on to the end and to the samples.
  const Matrix2 end_with_sum = gathered_.end * transposed(t_s);
  const Matrix2 sum_with_sum = t_s * gathered_.end_sum;
  gathered_.sum = gathered_.sum + (sum_with_sum + transposed(sum_with_sum)) + t_s * end_with_sum;
  gathered_.end_sum = t * (gathered_.end_sum + end_with_sum);
  gathered_.end = t * (gathered_.end * transposed(t));

  // The noise of each step reaches the end and each sample from that step on. The numbers below
  // count how often, and through how many steps in the mean, to first order in the change of a
  // step.
  const Matrix2 moved = (1.0 / n) * ((t - 1.0) * noise);
  const Matrix2 moved_back = transposed(moved);
  const auto passed = [&](double steps, double other_steps) {
    return noise + steps * moved + other_steps * moved_back;
  };
  const double left = n - 1.0;
  const double pairs = 0.5 * n * (n + 1.0);
  const double triples = pairs * (2.0 * n + 1.0) / 3.0;
  // Sum over m < n of m (m + 1)^2 / 2.
  const double through = n * left * (3.0 * n * left + 4.0 * (2.0 * n - 1.0) + 6.0) / 24.0;
  gathered_.end = gathered_.end + n * passed(0.5 * left, 0.5 * left);
  gathered_.end_sum = gathered_.end_sum + pairs * passed(2.0 / 3.0 * left, 1.0 / 3.0 * left);
  gathered_.sum = gathered_.sum + triples * passed(through / triples, through / triples);
}

RING_GYRO_NOT_INLINE const IntervalUpdate& IntervalFilter::update() {
  if (waiting_.size() > 0) settle();
  if (samples_ == 0) return update_ = {};
  measureMean(beliefs_[1 - present_]);
  keep(to_sum_.by_parameters);
  return update_;
}

RING_GYRO_FUSED_CLONES RING_GYRO_FLATTEN const IntervalUpdate& IntervalFilter::stepAndUpdate(
    const AveragedStep<double>& step, const Eigen::Vector2d& measured) {
  if (samples_ > 0 || waiting_.size() > 0) {
    this->step(step, measured);
    return update();
  }
  const DeviceParameters parameters = device();
  const AxesDynamics<double> dynamics(model_.decayRate(), model_.angularFrequency(), step);
  const AxesStepResult taken = AxesEquation(dynamics, parameters).step(axes_, step_duration_);
  elapsed_ = step_duration_;
  measureStep(taken, stepNoise(taken, axes_), vector2(measured) - taken.axes,
              beliefs_[1 - present_]);
  keep(taken.by_parameters);
  return update_;
}

/// Updates the covariance of the parameters with a measurement of the axes, which depends on them
/// by `regression` and has the covariance `conditional` given the parameters, with the measurement
/// noise. Returns the change of the parameters. Sets update_; it is not accepted if `conditional`
/// is not positive definite, which absurd inputs can cause.
inline Vector5 IntervalFilter::measureParameters(const Matrix2x5& regression,
                                                 const Matrix2& conditional,
                                                 const Vector2& innovation,
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

/// Update by a measurement of the step's end (docs/filter.md, sections 2 and 3).
inline void IntervalFilter::measureStep(const AxesStepResult& step, const Matrix2& noise,
                                        const Vector2& innovation, Belief& next) {
  const Matrix2& t = step.by_axes;
  const Matrix2x5 c = t * present().regression + step.by_parameters;
  const Matrix2 s = t * (present().conditional * transposed(t)) + noise;
  const Matrix2 measured = s + noise_.sample_variance;
  const Vector5 gained = measureParameters(c, measured, innovation, next.covariance);

  // The axes given the parameters: 1 - K = R (S + R)^-1 for the gain K = S (S + R)^-1.
  const Matrix2 rest = noise_.sample_variance * inverse(measured);
  next.regression = rest * c;
  next.parameters = present().parameters + gained;
  next.conditional = symmetric(s * rest);
  next.axes = (step.axes + (innovation - rest * innovation)) + next.regression * gained;
}

/// Update by a measurement of the mean of the interval's samples (docs/filter.md, section 3).
void IntervalFilter::measureMean(Belief& next) {
  const double share = 1.0 / samples_;
  const Matrix2& s = present().conditional;
  const Matrix2& t_e = to_end_.by_axes;
  const Matrix2 t_m = share * to_sum_.by_axes;
  const Matrix2x5 c_e = t_e * present().regression + to_end_.by_parameters;
  const Matrix2x5 c_m = t_m * present().regression + share * to_sum_.by_parameters;
  const Matrix2& n_e = gathered_.end;
  const Matrix2 n_em = share * gathered_.end_sum;
  const Matrix2 n_m = share * share * gathered_.sum + share * noise_.sample_variance;
  const Matrix2 s_with_mean = s * transposed(t_m);
  const Matrix2 measured = symmetric(t_m * s_with_mean + n_m);
  const Vector2 innovation = share * (measured_sum_ - predicted_sum_);
  const Vector5 gained = measureParameters(c_m, measured, innovation, next.covariance);

  // The axes given the parameters, with the covariance in Joseph's form.
  const Matrix2 gain = (t_e * s_with_mean + n_em) * inverse(measured);
  const Matrix2 rest = t_e - gain * t_m;
  const Matrix2 mixed = gain * transposed(n_em);
  next.regression = c_e - gain * c_m;
  next.parameters = present().parameters + gained;
  next.conditional = symmetric(rest * (s * transposed(rest)) + n_e - (mixed + transposed(mixed)) +
                               gain * (n_m * transposed(gain)));
  next.axes = (axes_ + gain * innovation) + next.regression * gained;
}

/// Makes the next belief the present one, unless the update is not accepted, and starts the next
/// interval. `shown`: how the measurement depends on the parameters.
inline void IntervalFilter::keep(const Matrix2x5& shown) {
  Belief& next = beliefs_[1 - present_];
  const Vector5 sum = next.parameters + (next.regression.first + next.regression.second);
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

/// Directional forgetting (Kulhavy; docs/filter.md, section 5): the covariance grows only along P
/// h, where the interval's measurement h has just made it smaller. What the data do not show, for
/// example while the pattern rests, stays as well known as it was.
RING_GYRO_NOT_INLINE void IntervalFilter::forget(const Matrix2x5& shown, Belief& belief) const {
  const double growth = std::expm1(elapsed_ / memory_time_);
  for (const Vector5& shown_row : {shown.first, shown.second}) {
    const ParameterVector row = eigen(shown_row);
    const ParameterVector direction = belief.covariance.matrix() * row;
    const double variance = row.dot(direction);
    if (variance > 0.0) addTo(belief, growth / variance, direction);
  }
}

/// Adds weight * direction direction' to the covariance of the parameters, and to nothing else.
void IntervalFilter::addTo(Belief& belief, double weight, const ParameterVector& direction) {
  const auto gained = belief.covariance.add(weight, direction, belief.regression);
  belief.conditional = belief.conditional + gained.weight * outer(gained.factor, gained.factor);
}

StateVector IntervalFilter::value() const { return stateOf(present().axes, present().parameters); }

StateMatrix IntervalFilter::covariance() const {
  const Eigen::Matrix<double, 2, 5> regression = eigen(present().regression);
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
  return eigen(present().covariance.variance());
}

StateVector IntervalFilter::variance() const {
  const Belief& belief = present();
  const Vector2 axes = belief.covariance.variance(belief.regression);
  StateVector result;
  result << belief.conditional.first[0] + axes[0], belief.conditional.second[1] + axes[1],
      parameterVariance();
  return result;
}

}  // namespace cvg
