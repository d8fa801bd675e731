#include "ring_gyro/identification/judge/information_bound.h"

#include <Eigen/LU>
#include <cmath>

#include "ring_gyro/common/square.h"
#include "ring_gyro/demodulation/orbit.h"

namespace cvg {
namespace {

/// Prior sigma of the moving states: wide, because the first block measures them.
double unknown(double sample_variance) { return 1e3 * std::sqrt(sample_variance); }

ExtendedMatrix linearPrior(const EnvelopeModel& model, const ExtendedVector& truth,
                           const ExtendedVector& sigma) {
  const ExtendedMatrix slope = model.state().linearByPhysical(truth);
  return slope * sigma.cwiseAbs2().asDiagonal() * slope.transpose();
}

}  // namespace

InformationBound::InformationBound(const ExtendedMatrix& prior, Eigen::Index moving)
    : moving_(moving),
      scale_(prior.diagonal().cwiseSqrt()),
      covariance_(prior.cwiseQuotient(scale_ * scale_.transpose())) {}

void InformationBound::step(const Rows& rows, double variance) {
  const Eigen::Index size = scale_.size();
  Rows scaled = rows;
  for (Eigen::Index k = 0; k < moving_; ++k) {
    scaled.row(k).array() *= scale_.transpose().array() / scale_[k];
  }
  const Rows moved = scaled * covariance_;
  const Eigen::Index constant = size - moving_;
  covariance_.topLeftCorner(moving_, moving_) = moved * scaled.transpose();
  covariance_.topRightCorner(moving_, constant) = moved.rightCols(constant);
  covariance_.bottomLeftCorner(constant, moving_) = moved.rightCols(constant).transpose();
  for (Eigen::Index k = 0; k < moving_; ++k) covariance_(k, k) += variance / square(scale_[k]);
}

void InformationBound::measure(const Rows& rows, double variance) {
  using Gain = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMostExtendedStates, 4>;
  using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 4, 4>;
  const Rows scaled = rows * scale_.asDiagonal();
  const Gain cross = covariance_ * scaled.transpose();
  Square innovation = scaled * cross;
  innovation.diagonal().array() += variance;
  const Gain gain = cross * innovation.inverse();
  // Joseph's form: (1 - K H) P (1 - K H)^T + K R K^T.
  ExtendedMatrix left = covariance_;
  left.noalias() -= gain * cross.transpose();
  const Gain left_cross = left * scaled.transpose();
  left.noalias() -= left_cross * gain.transpose();
  left.noalias() += variance * gain * gain.transpose();
  covariance_ = 0.5 * (left + left.transpose());
}

void InformationBound::forgetMoving(double sigma) {
  covariance_.topRows(moving_).setZero();
  covariance_.leftCols(moving_).setZero();
  for (Eigen::Index k = 0; k < moving_; ++k) covariance_(k, k) = square(sigma / scale_[k]);
}

ExtendedMatrix InformationBound::covariance() const {
  return (scale_ * scale_.transpose()).cwiseProduct(covariance_);
}

AxesBound::AxesBound(const AveragedModel& model, const DeviceParameters& truth,
                     const StateVector& prior_sigma, double noise_density, double process_noise,
                     const ConverterParameters& converter)
    : model_(model),
      truth_(truth),
      sample_variance_(square(noise_density) / converter.blockDuration()),
      rate_density_(square(process_noise)),
      chain_(converter.blockDurationNanoseconds()),
      bound_(ExtendedMatrix(prior_sigma.cwiseAbs2().asDiagonal()), 2) {}

void AxesBound::process(const OrbitalElements& elements, const ControlGains& gains) {
  if (chain_.admit(elements, gains, 0.0) != BlockUse::kUsable) {
    chained_ = false;
    return;
  }
  const Orbit& now = chain_.last().orbit;
  if (!chained_ || !chain_.follows()) {
    axes_ << now.a, now.b;
    bound_.forgetMoving(unknown(sample_variance_));
  } else {
    const Orbit& before = chain_.before().orbit;
    AveragedInput input;
    input.pattern_rate = (now.theta - before.theta) / elements.stamp.duration();
    for (const ChainSegment& segment : chain_.segments()) {
      if (segment.duration <= 0.0) continue;
      input.drive = segment.input.drive;
      input.reference_frequency = segment.input.reference_frequency;
      const Orbit middle{axes_[0], axes_[1], segment.input.theta,
                         before.phi + segment.middle * (now.phi - before.phi)};
      const AxesStep step = model_.axesStep(middle, truth_, input, segment.duration);
      axes_ = step.axes;
      InformationBound::Rows rows(2, 7);
      rows << step.by_axes, step.by_parameters;
      bound_.step(rows, segment.duration * rate_density_);
    }
  }
  chained_ = true;
  bound_.measure(InformationBound::Rows::Identity(2, 7), sample_variance_);
}

StateMatrix AxesBound::covariance() const { return bound_.covariance(); }

EnvelopeBound::EnvelopeBound(const EnvelopeModel& model, const ExtendedVector& truth,
                             const ExtendedVector& prior_sigma, double noise_density,
                             double process_noise, const ConverterParameters& converter)
    : model_(model),
      truth_(model.state().linear(truth)),
      sample_variance_(square(noise_density) / converter.blockDuration()),
      rate_density_(square(process_noise)),
      chain_(converter.blockDurationNanoseconds()),
      bound_(linearPrior(model, truth, prior_sigma), 4) {}

void EnvelopeBound::process(const OrbitalElements& elements, const ControlGains& gains,
                            double rotation_rate) {
  if (chain_.admit(elements, gains, rotation_rate) != BlockUse::kUsable) {
    chained_ = false;
    return;
  }
  const Orbit& now = chain_.last().orbit;
  const Eigen::Index size = truth_.size();
  if (!chained_ || !chain_.follows()) {
    truth_.head<4>() = model_.undistorted(realParts(envelopeFromOrbit(now)), truth_);
    bound_.forgetMoving(unknown(sample_variance_));
  } else {
    for (const ChainSegment& segment : chain_.segments()) {
      if (segment.duration <= 0.0) continue;
      const Eigen::Vector4d envelope = truth_.head<4>();
      model_.step(envelope, truth_, {envelope, truth_}, segment.input, segment.duration, step_);
      truth_.head<4>() = step_.after;
      InformationBound::Rows rows(4, size);
      rows << step_.transition, step_.by_parameters;
      bound_.step(rows, segment.duration * rate_density_);
    }
  }
  chained_ = true;
  const EnvelopeModel::Measurement shown = model_.measure(truth_.head<4>(), truth_);
  InformationBound::Rows rows = InformationBound::Rows::Zero(4, size);
  rows.leftCols<4>() = shown.by_envelope;
  if (model_.state().layout().pickoff_cubic >= 0) {
    rows.col(model_.state().layout().pickoff_cubic) = shown.by_cubic;
  }
  bound_.measure(rows, sample_variance_);
}

ExtendedMatrix EnvelopeBound::covariance() const {
  const ExtendedMatrix slope = model_.state().physicalByLinear(truth_);
  const ExtendedMatrix covariance = slope * bound_.covariance() * slope.transpose();
  return 0.5 * (covariance + covariance.transpose());
}

}  // namespace cvg
