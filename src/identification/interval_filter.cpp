#include "ring_gyro/identification/interval_filter.h"

#include <cmath>

#include "ring_gyro/common/vector_dispatch.h"

namespace ring_gyro {

namespace {

/// Takes the measured axes, the first two states, one after the other. `innovation` is that of
/// both before; `correction` is what the states gain.
template <int Moving>
IntervalUpdate measureAxes(FactoredCovariance<Moving>& covariance,
                           const Eigen::Vector2d& innovation, double noise_variance,
                           typename FactoredCovariance<Moving>::Vector& correction) {
  const auto a = covariance.template measure<0>(noise_variance);
  const auto b = covariance.template measure<1>(noise_variance);
  const double a_share = innovation[0] * a.inverse_variance;
  const double b_innovation = innovation[1] - a_share * a.cross[1];
  const double b_share = b_innovation * b.inverse_variance;
  correction = a_share * a.cross + b_share * b.cross;

  IntervalUpdate update;
  update.innovation = innovation;
  update.innovation_covariance << a.variance, a.cross[1], a.cross[1],
      b.variance + a.cross[1] * a.cross[1] * a.inverse_variance;
  update.normalised_innovation_squared = innovation[0] * a_share + b_innovation * b_share;
  return update;
}

}  // namespace

IntervalFilter::IntervalFilter(const AveragedModel& model, const IntervalNoise& noise)
    : model_(model), noise_(noise) {
  initialise(StateVector::Zero(), StateVector::Zero(), ParameterVector::Zero());
}

void IntervalFilter::initialise(const StateVector& value, const StateVector& sigma,
                                const ParameterVector& walk, double memory_time) {
  drive_gain_scale_ = value[kDriveGain];
  value_ = value;
  covariances_[present_] = Covariance(sigma.cwiseAbs2());
  variance_growth_ = walk.cwiseAbs2();
  walks_ = !variance_growth_.isZero(0.0);
  memory_time_ = memory_time;
  abandon();
}

void IntervalFilter::restartAxes(const Eigen::Vector2d& axes, double sigma) {
  value_.head<2>() = axes;
  covariances_[present_].restartMoving(sigma * sigma);
  abandon();
}

void IntervalFilter::abandon() {
  device_ = device();
  axes_ = value_.head<2>();
  elapsed_ = 0.0;
  moved_ = summed_ = false;
  samples_ = 0;
}

DeviceParameters IntervalFilter::device() const {
  return {value_[kGamma1], value_[kGamma2], value_[kMu1], value_[kMu2], value_[kDriveGain]};
}

bool IntervalFilter::isLinearOver(double duration, int samples, double reference_frequency) const {
  const auto sigma = [this](int state) {
    return std::sqrt(covariances_[present_].variance(state));
  };
  const double decay = model_.decayRate();
  const double gamma = decay * std::hypot(sigma(kGamma1), sigma(kGamma2));
  const double mu = 0.5 * reference_frequency * std::hypot(sigma(kMu1), sigma(kMu2));
  const double force = decay * sigma(kDriveGain) / std::abs(drive_gain_scale_);
  // The axes are off by what they are off now and by what they gather on the way; the uncertain
  // rates act on that error.
  const double gathered = 0.5 * (gamma + mu + force) * duration * axes_.norm();
  const double axes = std::hypot(sigma(kA), sigma(kB)) + gathered;
  const double neglected = axes * (gamma + mu) * duration;
  return neglected < 0.1 * std::sqrt(noise_.sample_variance / samples);
}

void IntervalFilter::step(double theta, double phi, const AveragedInput& input, double duration) {
  const AxesStep step = model_.axesStep({axes_[0], axes_[1], theta, phi}, device_, input, duration);

  const Eigen::Matrix2d& by_angles = step.rate_by_angles;
  const double angle_variance = duration * noise_.angle_density / axes_.squaredNorm();
  Eigen::Matrix2d noise = angle_variance * by_angles * by_angles.transpose();
  noise.diagonal().array() += duration * noise_.axes_density;

  axes_ = step.axes;
  elapsed_ += duration;
  if (!moved_) {
    moved_ = true;
    sensitivity_.leftCols<2>() = step.by_axes;
    sensitivity_.rightCols<5>() = step.by_parameters;
    noise_end_ = noise;
    return;
  }
  if (samples_ == 1) beginSums();
  for (int state = 0; state < sensitivity_.cols(); ++state) {
    sensitivity_.col(state) = step.by_axes * Eigen::Vector2d(sensitivity_.col(state));
  }
  sensitivity_.rightCols<5>() += step.by_parameters;
  noise_end_ = step.by_axes * Eigen::Matrix2d(noise_end_ * step.by_axes.transpose()) + noise;
  if (samples_ > 0) noise_end_sum_ = step.by_axes * Eigen::Matrix2d(noise_end_sum_);
}

/// An interval of one sample, the usual one at the rate of the blocks, has no need of sums.
void IntervalFilter::beginSums() {
  if (summed_) return;
  summed_ = true;
  sensitivity_sum_ = sensitivity_;
  noise_sum_ = noise_end_;
  noise_end_sum_ = noise_end_;
}

void IntervalFilter::sample(const Eigen::Vector2d& measured) {
  if (!moved_) {
    // Sampled where the interval begins.
    moved_ = true;
    sensitivity_ << Eigen::Matrix2d::Identity(), Eigen::Matrix<double, 2, 5>::Zero();
    noise_end_.setZero();
  }
  if (samples_ == 1) beginSums();
  if (++samples_ == 1) {
    predicted_sum_ = axes_;
    measured_sum_ = measured;
    return;
  }
  predicted_sum_ += axes_;
  measured_sum_ += measured;
  sensitivity_sum_ += sensitivity_;
  noise_sum_ += noise_end_sum_ + noise_end_sum_.transpose() + noise_end_;
  noise_end_sum_ += noise_end_;
}

IntervalUpdate IntervalFilter::update() {
  if (samples_ == 0) return {};
  StateVector value;
  IntervalUpdate result;
  if (samples_ == 1) {
    measureSample(value, result);
  } else {
    measureMean(value, result);
  }
  Covariance& covariance = covariances_[1 - present_];
  result.accepted = std::isfinite(value.sum() + result.innovation_covariance.sum() +
                                  result.normalised_innovation_squared) &&
                    covariance.isFinite();
  if (!result.accepted) {
    abandon();
    return {};
  }
  if (walks_) covariance.addToConstants(elapsed_ * variance_growth_);
  if (memory_time_ > 0.0) forget(covariance);
  present_ = 1 - present_;
  value_ = value;
  abandon();
  return result;
}

/// Directional forgetting (Kulhavy): the covariance grows along P h, where the interval's
/// measurement h has just made it smaller, and nowhere else. What the data do not show, as with a
/// pattern at rest, stays as well known as it was.
void IntervalFilter::forget(Covariance& covariance) const {
  const double growth = std::expm1(elapsed_ / memory_time_);
  for (int axis = 0; axis < 2; ++axis) {
    const ParameterVector shown = sensitivity_sum_.row(axis).tail<5>();
    const ParameterVector direction = covariance.matrix().bottomRightCorner<5, 5>() * shown;
    const double variance = shown.dot(direction);
    if (variance > 0.0) covariance.addToConstants(growth / variance, direction);
  }
}

RING_GYRO_VECTOR_CLONES RING_GYRO_FLATTEN void IntervalFilter::measureSample(
    StateVector& value, IntervalUpdate& update) {
  Covariance covariance;  // here, so that it can stay in registers
  covariances_[present_].propagate<2>(sensitivity_, noise_end_, covariance);
  Covariance::Vector correction;
  update =
      measureAxes(covariance, measured_sum_ - predicted_sum_, noise_.sample_variance, correction);
  covariances_[1 - present_] = covariance;
  value.head<2>() = axes_ + correction.head<2>();
  value.tail<5>() = value_.tail<5>() + correction.segment<5>(2);
}

/// The mean and the end of the interval move, the mean is measured; then it is of no more use.
void IntervalFilter::measureMean(StateVector& value, IntervalUpdate& update) {
  const double share = 1.0 / samples_;
  Eigen::Matrix<double, 4, 7> sensitivity;
  sensitivity << share * sensitivity_sum_, sensitivity_;
  Eigen::Matrix4d noise;
  noise << share * share * noise_sum_, share * noise_end_sum_.transpose(),  //
      share * noise_end_sum_, noise_end_;
  FactoredCovariance<4> covariance;
  covariances_[present_].propagate<4>(sensitivity, noise, covariance);
  FactoredCovariance<4>::Vector correction;
  update = measureAxes(covariance, share * (measured_sum_ - predicted_sum_),
                       share * noise_.sample_variance, correction);
  covariances_[1 - present_] = covariance.without<2>();
  value.head<2>() = axes_ + correction.segment<2>(2);
  value.tail<5>() = value_.tail<5>() + correction.segment<5>(4);
}

RING_GYRO_FLATTEN StateMatrix IntervalFilter::covariance() const {
  return covariances_[present_].matrix();
}

}  // namespace ring_gyro
