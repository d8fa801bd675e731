#pragma once

#include <Eigen/Core>

#include "ring_gyro/identification/model/envelope_model.h"

namespace cvg {

/// Outcome of one update of the envelope filter.
struct EnvelopeUpdate {
  bool accepted = false;  ///< false: no sample, or a number not finite; nothing was changed
  Eigen::Vector4d innovation = Eigen::Vector4d::Zero();             ///< of the mean [V]
  Eigen::Matrix4d innovation_covariance = Eigen::Matrix4d::Zero();  ///< [V^2]
  double normalised_innovation_squared = 0.0;
};

/// Extended Kalman filter on the envelope model that uses the mean of the measured envelope over an
/// interval as one measurement. It works like IntervalFilter, but with the four parts of the
/// envelope, the states of the chosen groups of parameters, and a full covariance. States are in
/// linear coordinates (ExtendedState). Does not allocate.
class EnvelopeFilter {
 public:
  /// `sample_variance`: of each part of the envelope in a sample over `sample_duration` [s], white
  /// [V^2]; `rate_density`: of each part of its rate, white, two-sided [V^2/s].
  EnvelopeFilter(const EnvelopeModel& model, double sample_variance, double sample_duration,
                 double rate_density);

  /// Forgets everything and starts an interval. `scale`: typical size of each state, above zero;
  /// `walk`: variance growth of the states [unit^2/s]. All in linear coordinates.
  void initialise(const ExtendedVector& value, const ExtendedMatrix& covariance,
                  const ExtendedVector& scale, const ExtendedVector& walk);
  /// Forgets the envelope and keeps the parameters; the envelope becomes `envelope` with standard
  /// deviation `sigma` [V] of each part, without correlations. Starts an interval.
  void restartEnvelope(const Eigen::Vector4d& envelope, double sigma);

  /// Whether one interval of `duration` [s] from here on is linear enough: products of the
  /// uncertainties of envelope and rates stay below a tenth of the noise of the mean of `samples`.
  bool isLinearOver(double duration, int samples, const EnvelopeInput& input) const;

  /// From now on linearise at these parameters (linear coordinates) and at the measured envelope,
  /// not at the estimate. While little is known the estimate moves, and derivatives taken at it
  /// would give the filter information that the data do not contain. Call it between intervals.
  void linearise(const ExtendedVector& nominal);
  /// From now on linearise at the estimate, as an extended Kalman filter does.
  void lineariseAtEstimate() { at_estimate_ = true; }
  bool linearisesAtEstimate() const { return at_estimate_; }

  /// `measured`: envelope in the middle of the step [V]; used when not linearising at the estimate.
  void step(const EnvelopeInput& input, const Eigen::Vector4d& measured, double duration);
  /// Uncertainty of the matrix that acts on an error of the envelope: root of the sum of the
  /// variances of its parts [1/s].
  double matrixSigma(const EnvelopeInput& input) const;
  /// Distance of that matrix at the estimate from the one at which the filter is linearised [1/s].
  double matrixMoved(const EnvelopeInput& input) const;
  /// Adds a measured envelope [V] to the interval's mean.
  void sample(const Eigen::Vector4d& measured);
  /// Ends the interval with its update and starts the next.
  EnvelopeUpdate update();
  /// Goes back to the start of the interval and drops what it has gathered.
  void abandon();

  const ExtendedVector& value() const { return value_; }  ///< at the end of the last interval
  ExtendedMatrix covariance() const;
  const EnvelopeModel& model() const { return model_; }

 private:
  /// Sum of the squared errors of the parts of the matrix of matrixSigma(), from the squared errors
  /// of the parameters.
  double matrixSquare(const ExtendedVector& squares, const EnvelopeInput& input) const;

  EnvelopeModel model_;
  double sample_variance_;
  double sample_duration_;
  double rate_density_;
  ExtendedVector scale_;
  ExtendedVector value_;
  ExtendedMatrix covariance_;       // of the scaled state
  ExtendedVector variance_growth_;  // of the scaled state [1/s]
  bool at_estimate_ = true;
  ExtendedVector nominal_;  // where to linearise if not at the estimate
  // The model is linearised at the measured envelope, so the noise of this envelope acts on the
  // rate through the error of nominal_: density of that noise [V^2/s].
  double nominal_density_ = -1.0;  // negative: is found at the interval's first step

  // The running interval.
  Eigen::Vector4d envelope_;
  EnvelopeSensitivity sensitivity_;  // to the state at the interval's start, not scaled
  double elapsed_ = 0.0;
  int samples_ = 0;
  Eigen::Vector4d predicted_sum_;
  Eigen::Vector4d measured_sum_;
  EnvelopeSensitivity sensitivity_sum_;
  // Covariance of the process noise: of the envelope, between it and the sum of the predictions, of
  // the sum.
  Eigen::Matrix4d noise_end_;
  Eigen::Matrix4d noise_end_sum_;
  Eigen::Matrix4d noise_sum_;
  EnvelopeStep step_;
};

}  // namespace cvg
