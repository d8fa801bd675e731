#pragma once

#include <Eigen/Core>

#include "ring_gyro/identification/averaged_model.h"
#include "ring_gyro/identification/factored_covariance.h"
#include "ring_gyro/identification/parameter_estimate.h"

namespace ring_gyro {

/// What the filter assumes of the noise.
struct IntervalNoise {
  double sample_variance = 0.0;  ///< of a and of b in one sample, white from sample to sample [V^2]
  double axes_density = 0.0;     ///< of a' and b', white, two-sided [V^2/s]
  /// Of the measured theta and phi times a, white, two-sided [V^2 s]. The angles are inputs of the
  /// model: their noise acts on a' and b' through the slopes of the rates.
  double angle_density = 0.0;
};

/// Outcome of one update.
struct IntervalUpdate {
  bool accepted = false;  ///< false: a number was not finite, or no sample; nothing was changed
  Eigen::Vector2d innovation = Eigen::Vector2d::Zero();             ///< of the mean a, b [V]
  Eigen::Matrix2d innovation_covariance = Eigen::Matrix2d::Zero();  ///< [V^2]
  double normalised_innovation_squared = 0.0;
};

/// Extended Kalman filter of (29) that takes the mean of a and b over an interval as one
/// measurement.
///
/// Within the interval it carries the predicted axes and their derivatives with respect to the
/// state at the interval's start from step to step, so nothing is decimated and the covariance is
/// touched once an interval. Parameters stay constant within it, so only the rows of a and b of the
/// transition differ from identity. Process noise enters the end state, the mean and their
/// covariance exactly. An interval of one sample is an ordinary filter step.
///
/// The covariance is kept factored (FactoredCovariance) and cannot lose its positive sign. The mean
/// joins the states as two more that move, is measured and is dropped.
class IntervalFilter {
 public:
  IntervalFilter(const AveragedModel& model, const IntervalNoise& noise);

  using ParameterVector = Eigen::Matrix<double, 5, 1>;  ///< gamma1, gamma2, mu1, mu2, ks

  /// Forgets everything and starts an interval. value[kDriveGain], not zero, sets the scale of ks;
  /// `walk`: random walk of the parameters [unit of the parameter / sqrt(s)]. `memory_time`: after
  /// which data count for 1/e, 0: they count for ever [s].
  void initialise(const StateVector& value, const StateVector& sigma, const ParameterVector& walk,
                  double memory_time = 0.0);
  /// Forgets a and b, keeps the parameters: `axes` with standard deviation `sigma` [V], correlated
  /// with nothing. Starts an interval.
  void restartAxes(const Eigen::Vector2d& axes, double sigma);

  /// Whether one interval of `duration` [s] from here on is linear enough: what the derivatives
  /// leave out, products of the uncertainties of axes and parameters, stays under a tenth of the
  /// noise of the mean of `samples`. `reference_frequency`: w [rad/s].
  bool isLinearOver(double duration, int samples, double reference_frequency) const;

  /// Propagates over `duration` [s]; theta, phi: measured, in the middle of it.
  void step(double theta, double phi, const AveragedInput& input, double duration);
  /// Adds a measured (a, b) [V] to the interval's mean.
  void sample(const Eigen::Vector2d& measured);
  /// Ends the interval with its update and starts the next.
  IntervalUpdate update();
  /// Drops what the interval has gathered, back to its start.
  void abandon();

  /// State at the end of the last interval.
  const StateVector& value() const { return value_; }
  StateMatrix covariance() const;

 private:
  using Sensitivity = Eigen::Matrix<double, 2, 7>;  // of a, b to the state at the interval's start
  using Covariance = FactoredCovariance<2>;

  void forget(Covariance& covariance) const;
  DeviceParameters device() const;
  void beginSums();
  // To the other covariance, which counts once all numbers are known to be finite.
  void measureSample(StateVector& value, IntervalUpdate& update);
  void measureMean(StateVector& value, IntervalUpdate& update);

  AveragedModel model_;
  IntervalNoise noise_;
  double drive_gain_scale_ = 1.0;
  StateVector value_;
  Covariance covariances_[2];
  int present_ = 0;                  // which of them
  ParameterVector variance_growth_;  // of the parameters [unit of the parameter^2 / s]
  bool walks_ = false;
  double memory_time_ = 0.0;  // 0: for ever

  // The running interval. What it gathers is set by its first step or sample.
  bool moved_ = false;
  bool summed_ = false;
  DeviceParameters device_;
  Eigen::Vector2d axes_;
  Sensitivity sensitivity_;
  double elapsed_ = 0.0;
  int samples_ = 0;
  Eigen::Vector2d predicted_sum_;
  Eigen::Vector2d measured_sum_;
  Sensitivity sensitivity_sum_;
  // Process noise gathered by a and b: of the end, between the end and the sum, of the sum.
  Eigen::Matrix2d noise_end_;
  Eigen::Matrix2d noise_end_sum_;
  Eigen::Matrix2d noise_sum_;
};

}  // namespace ring_gyro
