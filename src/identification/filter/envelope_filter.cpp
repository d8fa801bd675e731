#include "ring_gyro/identification/filter/envelope_filter.h"

#include <Eigen/LU>
#include <cmath>

namespace cvg {

EnvelopeFilter::EnvelopeFilter(const EnvelopeModel& model, double sample_variance,
                               double sample_duration, double rate_density)
    : model_(model),
      sample_variance_(sample_variance),
      sample_duration_(sample_duration),
      rate_density_(rate_density) {
  const Eigen::Index size = model_.state().size();
  scale_.setOnes(size);
  value_.setZero(size);
  covariance_.setZero(size, size);
  variance_growth_.setZero(size);
  abandon();
}

void EnvelopeFilter::initialise(const ExtendedVector& value, const ExtendedMatrix& covariance,
                                const ExtendedVector& scale, const ExtendedVector& walk) {
  scale_ = scale;
  value_ = value;
  covariance_ = covariance.cwiseQuotient(scale * scale.transpose());
  variance_growth_ = walk.cwiseQuotient(scale.cwiseAbs2());
  abandon();
}

void EnvelopeFilter::restartEnvelope(const Eigen::Vector4d& envelope, double sigma) {
  value_.head<4>() = envelope;
  covariance_.topRows<4>().setZero();
  covariance_.leftCols<4>().setZero();
  covariance_.diagonal().head<4>() = (sigma * scale_.head<4>().cwiseInverse()).cwiseAbs2();
  abandon();
}

void EnvelopeFilter::abandon() {
  const Eigen::Index size = value_.size();
  envelope_ = value_.head<4>();
  sensitivity_.setZero(4, size);
  sensitivity_.leftCols<4>().setIdentity();
  elapsed_ = 0.0;
  samples_ = 0;
  nominal_density_ = -1.0;
  predicted_sum_.setZero();
  measured_sum_.setZero();
  sensitivity_sum_.setZero(4, size);
  noise_end_.setZero();
  noise_end_sum_.setZero();
  noise_sum_.setZero();
}

void EnvelopeFilter::linearise(const ExtendedVector& nominal) {
  nominal_ = nominal;
  at_estimate_ = false;
}

double EnvelopeFilter::matrixSigma(const EnvelopeInput& input) const {
  return std::sqrt(matrixSquare(covariance_.diagonal().cwiseProduct(scale_.cwiseAbs2()), input));
}

double EnvelopeFilter::matrixMoved(const EnvelopeInput& input) const {
  return at_estimate_ ? 0.0 : std::sqrt(matrixSquare((value_ - nominal_).cwiseAbs2(), input));
}

double EnvelopeFilter::matrixSquare(const ExtendedVector& squares,
                                    const EnvelopeInput& input) const {
  const EnvelopeSensitivity rate = model_.rateByParameters(value_.head<4>(), value_, input);
  const ExtendedState::Layout& at = model_.state().layout();
  double sum = 0.0;
  for (Eigen::Index k = 0; k < rate.cols(); ++k) {
    const Eigen::Index state = k + 4;
    const bool of_drive =
        state == at.drive_gain || state == at.drive_phase ||
        (at.mismatch >= 0 && state >= at.mismatch && state < at.mismatch + 4) ||
        (at.drive_rotation >= 0 && state >= at.drive_rotation && state < at.drive_rotation + 2);
    if (!of_drive) sum += rate.col(k).squaredNorm() * squares[state];
  }
  return sum / value_.head<4>().squaredNorm();
}

bool EnvelopeFilter::isLinearOver(double duration, int samples, const EnvelopeInput& input) const {
  if (!at_estimate_) return true;
  const Eigen::Index parameters = value_.size() - 4;
  // Errors of the rate, and of the matrix that acts on an error of the envelope. For the matrix the
  // correlations between parameters are not used.
  const EnvelopeSensitivity rate = model_.rateByParameters(value_.head<4>(), value_, input) *
                                   scale_.tail(parameters).asDiagonal();
  const double rate_variance =
      (rate * covariance_.bottomRightCorner(parameters, parameters) * rate.transpose()).trace();
  const double envelope_sigma =
      std::sqrt(covariance_.diagonal().head<4>().cwiseProduct(scale_.head<4>().cwiseAbs2()).sum());
  const double off = envelope_sigma + 0.5 * std::sqrt(rate_variance) * duration;
  const double neglected = off * matrixSigma(input) * duration;
  return neglected < 0.1 * std::sqrt(sample_variance_ / samples);
}

void EnvelopeFilter::step(const EnvelopeInput& input, const Eigen::Vector4d& measured,
                          double duration) {
  if (at_estimate_) {
    model_.step(envelope_, value_, {envelope_, value_}, input, duration, step_);
  } else {
    if (nominal_density_ < 0.0) {
      const ExtendedVector squares =
          (value_ - nominal_).cwiseAbs2() + covariance_.diagonal().cwiseProduct(scale_.cwiseAbs2());
      nominal_density_ = sample_variance_ * sample_duration_ * matrixSquare(squares, input);
    }
    const Eigen::Vector4d middle = model_.undistorted(measured, nominal_);
    model_.step(envelope_, value_, {middle, nominal_}, input, duration, step_);
  }
  envelope_ = step_.after;
  const EnvelopeSensitivity before = sensitivity_;
  sensitivity_.noalias() = step_.transition * before;
  sensitivity_.rightCols(value_.size() - 4) += step_.by_parameters;
  const Eigen::Matrix4d carried = step_.transition * noise_end_;
  noise_end_.noalias() = carried * step_.transition.transpose();
  double density = rate_density_;
  if (!at_estimate_) density += nominal_density_;
  noise_end_.diagonal().array() += duration * density;
  const Eigen::Matrix4d carried_sum = step_.transition * noise_end_sum_;
  noise_end_sum_ = carried_sum;
  elapsed_ += duration;
}

void EnvelopeFilter::sample(const Eigen::Vector4d& measured) {
  ++samples_;
  measured_sum_ += measured;
  const int cubic = model_.state().layout().pickoff_cubic;
  if (cubic < 0) {
    predicted_sum_ += envelope_;
    sensitivity_sum_ += sensitivity_;
    noise_sum_ += noise_end_sum_ + noise_end_sum_.transpose() + noise_end_;
    noise_end_sum_ += noise_end_;
    return;
  }
  const Eigen::Vector4d point = at_estimate_ ? envelope_ : model_.undistorted(measured, nominal_);
  const EnvelopeModel::Measurement shown = model_.measure(point, at_estimate_ ? value_ : nominal_);
  predicted_sum_ += shown.value;
  if (!at_estimate_) {
    predicted_sum_ += shown.by_envelope * (envelope_ - point) +
                      (value_[cubic] - nominal_[cubic]) * shown.by_cubic;
  }
  sensitivity_sum_.noalias() += shown.by_envelope * sensitivity_;
  sensitivity_sum_.col(cubic) += shown.by_cubic;
  const Eigen::Matrix4d cross = shown.by_envelope * noise_end_sum_;
  const Eigen::Matrix4d shown_noise = noise_end_ * shown.by_envelope.transpose();
  noise_sum_ += cross + cross.transpose() + shown.by_envelope * shown_noise;
  noise_end_sum_ += shown_noise;
}

EnvelopeUpdate EnvelopeFilter::update() {
  EnvelopeUpdate result;
  if (samples_ == 0) return result;
  const double share = 1.0 / samples_;
  using Gain = Eigen::Matrix<double, Eigen::Dynamic, 4, 0, kMostExtendedStates, 4>;

  // Everything from here on is in scaled states.
  const Eigen::Vector4d envelope_scale = scale_.head<4>();
  const EnvelopeSensitivity transition =
      envelope_scale.cwiseInverse().asDiagonal() * sensitivity_ * scale_.asDiagonal();
  const EnvelopeSensitivity measurement = share * sensitivity_sum_ * scale_.asDiagonal();
  const Eigen::Matrix4d end_noise = envelope_scale.cwiseInverse().asDiagonal() * noise_end_ *
                                    envelope_scale.cwiseInverse().asDiagonal();
  const Eigen::Matrix4d cross_noise =
      share * envelope_scale.cwiseInverse().asDiagonal() * noise_end_sum_;
  Eigen::Matrix4d mean_noise = share * share * noise_sum_;
  mean_noise.diagonal().array() += share * sample_variance_;

  const Gain start_cross = covariance_ * measurement.transpose();
  const Eigen::Matrix4d innovation_covariance = measurement * start_cross + mean_noise;
  Gain cross = start_cross;
  cross.topRows<4>() = transition * start_cross + cross_noise;
  const Eigen::Matrix4d information = innovation_covariance.inverse();
  const Gain gain = cross * information;
  const Eigen::Vector4d innovation = share * (measured_sum_ - predicted_sum_);
  ExtendedVector value = value_;
  value.head<4>() = envelope_;
  value += scale_.cwiseProduct(gain * innovation);

  // Joseph's form, as in IntervalFilter: the error of the start state passes through
  // transition - gain * measurement, process and measurement noise directly and through the gain.
  ExtendedMatrix mapped = covariance_;
  mapped.topRows<4>().noalias() = transition * covariance_;
  mapped.noalias() -= gain * start_cross.transpose();
  ExtendedMatrix covariance = mapped;
  covariance.leftCols<4>().noalias() = mapped * transition.transpose();
  const Gain mapped_cross = mapped * measurement.transpose();
  covariance.noalias() -= mapped_cross * gain.transpose();
  const Gain noisy_gain = gain * mean_noise;
  covariance.noalias() += noisy_gain * gain.transpose();
  const Gain noise_gain = gain * cross_noise.transpose();
  covariance.leftCols<4>() -= noise_gain;
  covariance.topRows<4>() -= noise_gain.transpose();
  covariance.topLeftCorner<4, 4>() += end_noise;
  covariance.diagonal() += elapsed_ * variance_growth_;
  mapped = 0.5 * (covariance + covariance.transpose());

  if (!value.allFinite() || !mapped.allFinite() || !information.allFinite() ||
      !(mapped.diagonal().minCoeff() >= 0.0)) {
    abandon();
    return result;
  }
  value_ = value;
  covariance_ = mapped;
  abandon();

  result.accepted = true;
  result.innovation = innovation;
  result.innovation_covariance = innovation_covariance;
  result.normalised_innovation_squared = innovation.dot(information * innovation);
  return result;
}

ExtendedMatrix EnvelopeFilter::covariance() const {
  return (scale_ * scale_.transpose()).cwiseProduct(covariance_);
}

}  // namespace cvg
