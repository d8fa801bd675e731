#pragma once

#include <Eigen/Core>

#include "ring_gyro/identification/model/envelope_input.h"
#include "ring_gyro/identification/model/extended_state.h"
#include "ring_gyro/signals/envelope.h"

namespace cvg {

using EnvelopeSensitivity = Eigen::Matrix<double, 4, Eigen::Dynamic, 0, 4, kMostExtendedStates>;

/// The point at which the model is linearised: envelope and parameters (linear coordinates).
struct EnvelopePoint {
  const Eigen::Vector4d& envelope;
  const ExtendedVector& linear;
};

/// One step of the envelope, with its derivatives with respect to the envelope before the step and
/// to the linear parameters (states from 4 on).
struct EnvelopeStep {
  Eigen::Vector4d after;
  Eigen::Matrix4d transition;
  EnvelopeSensitivity by_parameters;
};

/// The envelope U = [X; Y] of both axes in the frame of the NCO, as (re X, im X, re Y, im Y):
///
///     U' = (I - E) (L U - i/(2w) P F)
///     L = i D + i K2 M - d G + (k Om + r(theta)) J + k Om (s1 S1 + s2 S2 + ...)
///     E = (d G - k Om J + i D + i K2 M) / (2 i w),   P = ks e^{-ip} (I + drive matrix)
///
/// with the terms of ExtendedState; E has the second-order terms of docs/derivation.md, section 8.
/// The measured envelope is U + (3/4) c |U|^2 U on each axis.
class EnvelopeModel {
 public:
  explicit EnvelopeModel(const ExtendedState& state) : state_(state) {}

  /// One step over `duration` [s] from `envelope`, with the model linearised at `nominal`. If the
  /// envelope and the parameters are those of `nominal`, the step is exact to fourth order in rate
  /// times duration, and its derivatives to second.
  void step(const Eigen::Vector4d& envelope, const ExtendedVector& linear,
            const EnvelopePoint& nominal, const EnvelopeInput& input, double duration,
            EnvelopeStep& step) const;

  /// Derivative of the envelope's rate with respect to the linear parameters, first order [V/s per
  /// unit].
  EnvelopeSensitivity rateByParameters(const Eigen::Vector4d& envelope,
                                       const ExtendedVector& linear,
                                       const EnvelopeInput& input) const;

  /// The envelope that the pick-offs show [V], and its derivatives with respect to the true
  /// envelope and to the cubic term (zero when that is not estimated).
  struct Measurement {
    Eigen::Vector4d value;
    Eigen::Matrix4d by_envelope;
    Eigen::Vector4d by_cubic;
  };
  Measurement measure(const Eigen::Vector4d& envelope, const ExtendedVector& linear) const;
  /// The true envelope that pick-offs with the cubic term of `linear` show as `measured`.
  Eigen::Vector4d undistorted(const Eigen::Vector4d& measured, const ExtendedVector& linear) const;

  const ExtendedState& state() const { return state_; }

 private:
  ExtendedState state_;
};

Eigen::Vector4d realParts(const Envelope& envelope);  ///< (re X, im X, re Y, im Y)

}  // namespace cvg
