#include "ring_gyro/identification/interval_filter.h"

#include <Eigen/LU>
#include <cmath>

namespace ring_gyro {
namespace {

constexpr double kGammaScale = 1e-2;
constexpr double kMuScale = 1e-5;

}  // namespace

IntervalFilter::IntervalFilter(const AveragedModel& model, const IntervalNoise& noise)
    : model_(model), noise_(noise) {
  scale_ << 1.0, 1.0, kGammaScale, kGammaScale, kMuScale, kMuScale, 1.0;
  value_.setZero();
  covariance_.setZero();
  variance_growth_.setZero();
  abandon();
}

void IntervalFilter::initialise(const StateVector& value, const StateVector& sigma,
                                const ParameterVector& walk) {
  scale_[kDriveGain] = value[kDriveGain];
  value_ = value;
  covariance_.setZero();
  covariance_.diagonal() = sigma.cwiseQuotient(scale_).cwiseAbs2();
  variance_growth_ = walk.cwiseQuotient(scale_.tail<5>()).cwiseAbs2();
  abandon();
}

void IntervalFilter::restartAxes(const Eigen::Vector2d& axes, double sigma) {
  value_.head<2>() = axes;
  covariance_.topRows<2>().setZero();
  covariance_.leftCols<2>().setZero();
  covariance_.diagonal().head<2>().setConstant(sigma * sigma);
  abandon();
}

void IntervalFilter::abandon() {
  device_ = device();
  axes_ = value_.head<2>();
  sensitivity_.setZero();
  sensitivity_.leftCols<2>().setIdentity();
  elapsed_ = 0.0;
  samples_ = 0;
  predicted_sum_.setZero();
  measured_sum_.setZero();
  sensitivity_sum_.setZero();
  noise_end_.setZero();
  noise_end_sum_.setZero();
  noise_sum_.setZero();
}

DeviceParameters IntervalFilter::device() const {
  return {value_[kGamma1], value_[kGamma2], value_[kMu1], value_[kMu2], value_[kDriveGain]};
}

bool IntervalFilter::isLinearOver(double duration, int samples, double reference_frequency) const {
  const auto sigma = [this](int state) {
    return scale_[state] * std::sqrt(covariance_(state, state));
  };
  const double decay = model_.decayRate();
  const double gamma = decay * std::hypot(sigma(kGamma1), sigma(kGamma2));
  const double mu = 0.5 * reference_frequency * std::hypot(sigma(kMu1), sigma(kMu2));
  const double force = decay * std::sqrt(covariance_(kDriveGain, kDriveGain));
  // The axes are off by what they are off now and by what they gather on the way; the uncertain
  // rates act on that error.
  const double gathered = 0.5 * (gamma + mu + force) * duration * axes_.norm();
  const double axes = std::hypot(sigma(kA), sigma(kB)) + gathered;
  const double neglected = axes * (gamma + mu) * duration;
  return neglected < 0.1 * std::sqrt(noise_.sample_variance / samples);
}

void IntervalFilter::step(double theta, double phi, const AveragedInput& input, double duration) {
  const AxesStep step = model_.axesStep({axes_[0], axes_[1], theta, phi}, device_, input, duration);

  const double angle_variance = noise_.angle_density / axes_.squaredNorm();
  Eigen::Matrix2d density = angle_variance * step.rate_by_angles * step.rate_by_angles.transpose();
  density.diagonal().array() += noise_.axes_density;

  axes_ = step.axes;
  const Sensitivity before = sensitivity_;
  sensitivity_.noalias() = step.by_axes * before;
  sensitivity_.rightCols<5>() += step.by_parameters;
  const Eigen::Matrix2d carried = step.by_axes * noise_end_;
  noise_end_.noalias() = carried * step.by_axes.transpose();
  noise_end_ += duration * density;
  const Eigen::Matrix2d carried_sum = step.by_axes * noise_end_sum_;
  noise_end_sum_ = carried_sum;
  elapsed_ += duration;
}

void IntervalFilter::sample(const Eigen::Vector2d& measured) {
  ++samples_;
  predicted_sum_ += axes_;
  measured_sum_ += measured;
  sensitivity_sum_ += sensitivity_;
  noise_sum_ += noise_end_sum_ + noise_end_sum_.transpose() + noise_end_;
  noise_end_sum_ += noise_end_;
}

IntervalUpdate IntervalFilter::update() {
  IntervalUpdate result;
  if (samples_ == 0) return result;
  const double share = 1.0 / samples_;

  // Everything from here on is in scaled states; a and b have scale one.
  const Sensitivity transition = sensitivity_ * scale_.asDiagonal();
  const Sensitivity measurement = share * sensitivity_sum_ * scale_.asDiagonal();
  const Eigen::Matrix2d cross_noise = share * noise_end_sum_;
  Eigen::Matrix2d mean_noise = share * share * noise_sum_;
  mean_noise.diagonal().array() += share * noise_.sample_variance;

  using Gain = Eigen::Matrix<double, 7, 2>;
  const Gain start_cross = covariance_ * measurement.transpose();
  const Eigen::Matrix2d innovation_covariance = measurement * start_cross + mean_noise;
  Gain cross = start_cross;
  cross.topRows<2>() = transition * start_cross + cross_noise;
  const Eigen::Matrix2d information = innovation_covariance.inverse();
  const Gain gain = cross * information;
  const Eigen::Vector2d innovation = share * (measured_sum_ - predicted_sum_);
  StateVector value = value_;
  value.head<2>() = axes_;
  value += scale_.cwiseProduct(gain * innovation);

  // Joseph's form from the independent sources of error: the start state, through
  // transition - gain * measurement, and the process and measurement noise, which reach the end
  // state directly (a and b) and through the gain. The map is applied a factor at a time, because
  // only the rows of a and b of the transition differ from identity.
  StateMatrix mapped = covariance_;
  mapped.topRows<2>().noalias() = transition * covariance_;
  mapped.noalias() -= gain * start_cross.transpose();
  StateMatrix covariance = mapped;
  covariance.leftCols<2>().noalias() = mapped * transition.transpose();
  const Gain mapped_cross = mapped * measurement.transpose();
  covariance.noalias() -= mapped_cross * gain.transpose();
  covariance += gain * mean_noise * gain.transpose();
  const Gain noise_gain = gain * cross_noise.transpose();
  covariance.leftCols<2>() -= noise_gain;
  covariance.topRows<2>() -= noise_gain.transpose();
  covariance.topLeftCorner<2, 2>() += noise_end_;
  covariance.diagonal().tail<5>() += elapsed_ * variance_growth_;
  covariance = 0.5 * (covariance + covariance.transpose()).eval();

  if (!value.allFinite() || !covariance.allFinite() || !information.allFinite() ||
      !(covariance.diagonal().minCoeff() >= 0.0)) {
    abandon();
    return result;
  }
  value_ = value;
  covariance_ = covariance;
  abandon();

  result.accepted = true;
  result.innovation = innovation;
  result.innovation_covariance = innovation_covariance;
  result.normalised_innovation_squared = innovation.dot(information * innovation);
  return result;
}

StateMatrix IntervalFilter::covariance() const {
  // Products in an order that keeps the matrix symmetric to the last bit.
  return (scale_ * scale_.transpose()).cwiseProduct(covariance_);
}

}  // namespace ring_gyro
