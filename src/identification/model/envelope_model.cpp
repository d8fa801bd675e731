#include "ring_gyro/identification/model/envelope_model.h"

#include <cmath>
#include <complex>

#include "ring_gyro/common/angle.h"

namespace cvg {
namespace {

using Complex = std::complex<double>;
constexpr Complex kI{0.0, 1.0};

/// A matrix s I + along S1 + across S2 + turn J with S1 = diag(1, -1), S2 = [[0, 1], [1, 0]].
Eigen::Matrix2cd matrixOf(Complex scale, Complex along, Complex across, Complex turn) {
  Eigen::Matrix2cd result;
  result << scale + along, across + turn, across - turn, scale - along;
  return result;
}

Eigen::Matrix4d realMatrix(const Eigen::Matrix2cd& matrix) {
  Eigen::Matrix4d result;
  for (int row = 0; row < 2; ++row) {
    for (int column = 0; column < 2; ++column) {
      const Complex z = matrix(row, column);
      result.block<2, 2>(2 * row, 2 * column) << z.real(), -z.imag(), z.imag(), z.real();
    }
  }
  return result;
}

// The same products for (re X, im X, re Y, im Y).
Eigen::Vector4d timesI(const Eigen::Vector4d& u) { return {-u[1], u[0], -u[3], u[2]}; }
Eigen::Vector4d alongAxes(const Eigen::Vector4d& u) { return {u[0], u[1], -u[2], -u[3]}; }
Eigen::Vector4d acrossAxes(const Eigen::Vector4d& u) { return {u[2], u[3], u[0], u[1]}; }
Eigen::Vector4d turned(const Eigen::Vector4d& u) { return {u[2], u[3], -u[0], -u[1]}; }  // J u

/// The matrices of the rate (EnvelopeModel).
struct RateMatrices {
  Eigen::Matrix4d first_order;   // L
  Eigen::Matrix4d second_order;  // I - E
};

double rotationRate(const ExtendedState::Layout& at, const ExtendedVector& linear,
                    const EnvelopeInput& input) {
  return at.rotation_rate < 0 ? input.rotation_rate : linear[at.rotation_rate];
}

double harmonicSum(int first, const std::vector<int>& orders, const ExtendedVector& linear,
                   double theta) {
  double sum = 0.0;
  for (std::size_t k = 0; k < orders.size(); ++k) {
    const int place = first + 2 * static_cast<int>(k);
    sum += linear[place] * std::cos(orders[k] * theta) +
           linear[place + 1] * std::sin(orders[k] * theta);
  }
  return sum;
}

RateMatrices rateMatrices(const ExtendedState& state, const ExtendedVector& linear,
                          const EnvelopeInput& input) {
  const ExtendedState::Layout& at = state.layout();
  const double w = input.reference_frequency;
  const double w0 = state.angularFrequency(linear);
  const double detuning = 0.5 * (w0 - w) * (w0 + w) / w;
  const double coupling = 0.5 * w0 * w0 / w;
  const double rotation = rotationRate(at, linear, input);
  double turning = rotation;
  Complex complex_turning = 0.0;
  if (at.rotation_scale >= 0) turning += rotation * linear[at.rotation_scale];
  if (at.odd_harmonics >= 0) {
    turning += rotation * harmonicSum(at.odd_harmonics, state.oddOrders(), linear, input.theta);
  }
  if (at.drift_bias >= 0) {
    turning += linear[at.drift_bias];
    complex_turning = kI * linear[at.drift_bias + 1];
  }
  if (at.even_harmonics >= 0) {
    turning += harmonicSum(at.even_harmonics, state.evenOrders(), linear, input.theta);
  }
  const Complex stiffness1 = kI * (coupling * linear[at.mu]);
  const Complex stiffness2 = kI * (coupling * linear[at.mu + 1]);
  const double damping1 = linear[at.gamma];
  const double damping2 = linear[at.gamma + 1];
  const Complex scale(state.decayRate(linear), detuning);
  Complex sense1 = 0.0;
  Complex sense2 = 0.0;
  if (at.sense_mismatch >= 0) {
    // A sense matrix I + e1 S1 + e2 S2 turns J into J + 2 e1 S2 - 2 e2 S1.
    const int sense = at.sense_mismatch;
    sense1 = -2.0 * rotation * Complex(linear[sense + 1], linear[sense + 3]);
    sense2 = 2.0 * rotation * Complex(linear[sense], linear[sense + 2]);
  }
  const Eigen::Matrix2cd first =
      matrixOf({-scale.real(), scale.imag()}, stiffness1 - damping1 + sense1,
               stiffness2 - damping2 + sense2, turning + complex_turning);
  const Eigen::Matrix2cd second =
      (-0.5 / w) * matrixOf(-kI * scale, -kI * (stiffness1 + damping1),
                            -kI * (stiffness2 + damping2), kI * rotation);
  RateMatrices result;
  result.first_order = realMatrix(first);
  result.second_order = Eigen::Matrix4d::Identity() + realMatrix(second);
  return result;
}

Eigen::Vector4d driveForce(const ExtendedState& state, const ExtendedVector& linear,
                           const EnvelopeInput& input) {
  const ExtendedState::Layout& at = state.layout();
  Complex along = 0.0;
  Complex across = 0.0;
  if (at.mismatch >= 0) {
    along = {linear[at.mismatch], linear[at.mismatch + 2]};
    across = {linear[at.mismatch + 1], linear[at.mismatch + 3]};
  }
  Complex turn = 0.0;
  if (at.drive_rotation >= 0) {
    turn = {linear[at.drive_rotation], linear[at.drive_rotation + 1]};
  }
  const Envelope force = matrixOf(state.driveGain(linear), along, across, turn) * input.drive;
  return realParts(Complex(0.0, -0.5 / input.reference_frequency) * force);
}

}  // namespace

Eigen::Vector4d realParts(const Envelope& envelope) {
  return {envelope[0].real(), envelope[0].imag(), envelope[1].real(), envelope[1].imag()};
}

EnvelopeSensitivity EnvelopeModel::rateByParameters(const Eigen::Vector4d& envelope,
                                                    const ExtendedVector& linear,
                                                    const EnvelopeInput& input) const {
  const ExtendedState::Layout& at = state_.layout();
  const double w = input.reference_frequency;
  const double w0 = state_.angularFrequency(linear);
  const double coupling = 0.5 * w0 * w0 / w;
  const Eigen::Vector4d along = alongAxes(envelope);
  const Eigen::Vector4d across = acrossAxes(envelope);
  const Eigen::Vector4d turn = turned(envelope);
  EnvelopeSensitivity result(4, state_.size() - 4);
  const auto column = [&result](int state) { return result.col(state - 4); };
  column(at.gamma) = -along;
  column(at.gamma + 1) = -across;
  column(at.mu) = coupling * timesI(along);
  column(at.mu + 1) = coupling * timesI(across);
  const Eigen::Vector4d force = realParts(Complex(0.0, -0.5 / w) * input.drive);
  column(at.drive_gain) = force;
  if (at.decay_rate >= 0) column(at.decay_rate) = -envelope;
  if (at.frequency >= 0) {
    column(at.frequency) =
        (kTwoPi * w0 / w) * timesI(envelope + linear[at.mu] * along + linear[at.mu + 1] * across);
  }
  if (at.drive_phase >= 0) column(at.drive_phase) = timesI(force);
  if (at.mismatch >= 0) {
    column(at.mismatch) = alongAxes(force);
    column(at.mismatch + 1) = acrossAxes(force);
    column(at.mismatch + 2) = timesI(alongAxes(force));
    column(at.mismatch + 3) = timesI(acrossAxes(force));
  }
  if (at.drive_rotation >= 0) {
    column(at.drive_rotation) = turned(force);
    column(at.drive_rotation + 1) = timesI(turned(force));
  }
  if (at.drift_bias >= 0) {
    column(at.drift_bias) = turn;
    column(at.drift_bias + 1) = timesI(turn);
  }
  const auto harmonics = [&](int first, const std::vector<int>& orders, double factor) {
    for (std::size_t k = 0; k < orders.size(); ++k) {
      const int place = first + 2 * static_cast<int>(k);
      column(place) = factor * std::cos(orders[k] * input.theta) * turn;
      column(place + 1) = factor * std::sin(orders[k] * input.theta) * turn;
    }
  };
  const double rotation = rotationRate(at, linear, input);
  if (at.even_harmonics >= 0) harmonics(at.even_harmonics, state_.evenOrders(), 1.0);
  if (at.odd_harmonics >= 0) harmonics(at.odd_harmonics, state_.oddOrders(), rotation);
  if (at.sense_mismatch >= 0) {
    column(at.sense_mismatch) = 2.0 * rotation * across;
    column(at.sense_mismatch + 1) = -2.0 * rotation * along;
    column(at.sense_mismatch + 2) = 2.0 * rotation * timesI(across);
    column(at.sense_mismatch + 3) = -2.0 * rotation * timesI(along);
  }
  if (at.rotation_scale >= 0) column(at.rotation_scale) = rotation * turn;
  if (at.pickoff_cubic >= 0) column(at.pickoff_cubic).setZero();
  if (at.rotation_rate >= 0) {
    double scale = 1.0;
    if (at.odd_harmonics >= 0) {
      scale += harmonicSum(at.odd_harmonics, state_.oddOrders(), linear, input.theta);
    }
    column(at.rotation_rate) = scale * turn;
    if (at.sense_mismatch >= 0) {
      const int sense = at.sense_mismatch;
      column(at.rotation_rate) +=
          2.0 * (linear[sense] * across - linear[sense + 1] * along +
                 timesI(linear[sense + 2] * across - linear[sense + 3] * along));
    }
  }
  return result;
}

void EnvelopeModel::step(const Eigen::Vector4d& envelope, const ExtendedVector& linear,
                         const EnvelopePoint& nominal, const EnvelopeInput& input, double duration,
                         EnvelopeStep& step) const {
  const RateMatrices rate = rateMatrices(state_, nominal.linear, input);
  const Eigen::Matrix4d moved = duration * rate.second_order * rate.first_order;
  const Eigen::Vector4d force = rate.second_order * driveForce(state_, nominal.linear, input);
  const Eigen::Matrix4d identity = Eigen::Matrix4d::Identity();
  const Eigen::Matrix4d third = identity + (1.0 / 3.0) * moved + (1.0 / 12.0) * moved * moved;
  const Eigen::Matrix4d mean = identity + 0.5 * moved * third;  // mean transition over the step

  step.transition = identity + moved * mean;
  const Eigen::Vector4d change = moved * nominal.envelope + duration * force;
  const Eigen::Vector4d middle = nominal.envelope + 0.5 * change + 0.125 * (moved * change);
  const Eigen::Matrix4d carry = duration * (identity + 0.5 * moved) * rate.second_order;
  step.by_parameters.noalias() = carry * rateByParameters(middle, nominal.linear, input);
  step.after = step.transition * envelope + duration * (mean * force);
  if (&linear == &nominal.linear) return;
  const Eigen::Index parameters = state_.size() - 4;
  step.after += step.by_parameters * (linear - nominal.linear).tail(parameters);
}

EnvelopeModel::Measurement EnvelopeModel::measure(const Eigen::Vector4d& envelope,
                                                  const ExtendedVector& linear) const {
  Measurement result{envelope, Eigen::Matrix4d::Identity(), Eigen::Vector4d::Zero()};
  const int at = state_.layout().pickoff_cubic;
  if (at < 0) return result;
  const double factor = 0.75 * linear[at];
  for (int axis = 0; axis < 2; ++axis) {
    const Eigen::Vector2d part = envelope.segment<2>(2 * axis);
    const double square = part.squaredNorm();
    result.by_cubic.segment<2>(2 * axis) = 0.75 * square * part;
    result.value.segment<2>(2 * axis) += factor * square * part;
    auto block = result.by_envelope.block<2, 2>(2 * axis, 2 * axis);
    block += factor * (square * Eigen::Matrix2d::Identity() + 2.0 * part * part.transpose());
  }
  return result;
}

Eigen::Vector4d EnvelopeModel::undistorted(const Eigen::Vector4d& measured,
                                           const ExtendedVector& linear) const {
  Eigen::Vector4d envelope = measured;
  if (state_.layout().pickoff_cubic < 0) return envelope;
  // Each step reduces the error to a few per cent of it, the size of the distortion.
  for (int k = 0; k < 8; ++k) envelope += measured - measure(envelope, linear).value;
  return envelope;
}

}  // namespace cvg
