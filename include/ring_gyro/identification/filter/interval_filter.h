#pragma once

#include <Eigen/Core>

#include "ring_gyro/common/lanes.h"
#include "ring_gyro/common/pairs.h"
#include "ring_gyro/identification/filter/factored_covariance.h"
#include "ring_gyro/identification/model/averaged_model.h"
#include "ring_gyro/identification/model/averaged_step.h"
#include "ring_gyro/identification/model/axes_dynamics.h"
#include "ring_gyro/identification/model/parameter_lanes.h"
#include "ring_gyro/signals/parameter_estimate.h"

namespace cvg {

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
  /// false: a number was not finite, the noise of the measurement not positive definite, a variance
  /// below zero, or no sample; nothing was changed
  bool accepted = false;
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
/// The covariance is kept as that of a and b given the parameters, and as the factored covariance
/// of the parameters, which do not move: a step changes the former only, and no update can make a
/// variance negative.
class IntervalFilter {
 public:
  IntervalFilter(const AveragedModel& model, const IntervalNoise& noise);

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

  /// Adds a measured (a, b) [V] where the interval begins.
  void sample(const Eigen::Vector2d& measured);
  /// A step over `duration` [s] and the (a, b) [V] measured at its end.
  void step(const AveragedStep<double>& step, double duration, const Eigen::Vector2d& measured);
  /// The first `count`, 1 to kLanes, of several such steps, predicted each by itself. Derivatives
  /// and noise are those of one step over all of them at their mean: they only weigh the
  /// innovation, which needs no ninth digit.
  void steps(const AveragedStep<Lanes>& steps, int count, double duration, const Lanes& measured_a,
             const Lanes& measured_b);
  /// Ends the interval with its update and starts the next. What is given is good until the next
  /// update.
  const IntervalUpdate& update();
  /// A step() and an update() in one, at half the cost.
  const IntervalUpdate& stepAndUpdate(const AveragedStep<double>& step, double duration,
                                      const Eigen::Vector2d& measured);
  const IntervalUpdate& lastUpdate() const { return update_; }
  /// Drops what the interval has gathered, back to its start.
  void abandon();

  /// State at the end of the last interval.
  StateVector value() const;
  StateMatrix covariance() const;
  /// Diagonal of the covariance, as far as the parameters have it.
  ParameterVector parameterVariance() const;

 private:
  /// Errors of the state: those of the parameters, and those of a and b as what the parameters
  /// bring about, regression * error, and the rest.
  struct Belief {
    TwoLanes axes;
    ParameterLanes parameters;
    FactoredCovariance covariance;  ///< of the parameters
    ParameterRows regression;
    Square conditional;  ///< covariance of a and b given the parameters
  };
  /// How the end of an interval, or its mean, depends on the state at its start.
  struct Sensitivity {
    Square by_axes;
    ParameterRows by_parameters;
  };

  StateVector variance() const;
  const Belief& present() const { return beliefs_[present_]; }
  DeviceParameters device() const;
  void start();
  TwoLanes advance(const AxesDynamics<double>& mean, const TwoLanes& squares, int count,
                   double duration);
  void gatherNoise(const Square& transition, const Square& to_sum, const Square& noise, double n);
  double angleVariance(const TwoLanes& axes, double duration) const;
  Square stepNoise(const AxesStepPairs& step, const TwoLanes& axes, double duration) const;
  ParameterRows passedOn(const Square& by_axes, const ParameterRows& by_parameters) const;
  ParameterLanes measureParameters(const ParameterRows& regression, const Square& conditional,
                                   const TwoLanes& innovation, FactoredCovariance& next);
  void measureStep(const AxesStepPairs& step, const Square& noise, const TwoLanes& innovation,
                   Belief& next);
  void measureMean(Belief& next);
  void keep(const ParameterRows& shown);
  void walk(Belief& belief) const;
  void forget(const ParameterRows& shown, Belief& belief) const;
  static void addTo(Belief& belief, double weight, const ParameterVector& direction);

  AveragedModel model_;
  IntervalNoise noise_;
  double drive_gain_scale_ = 1.0;
  // The present one and room for the next, which counts once all its numbers are known to be
  // finite.
  Belief beliefs_[2];
  int present_ = 0;
  IntervalUpdate update_;
  ParameterVector variance_growth_;  // of the parameters [unit of the parameter^2 / s]
  bool walks_ = false;
  double memory_time_ = 0.0;  // 0: for ever

  // The running interval. What it gathers is set by its first sample, the sums by the second.
  TwoLanes axes_;
  Sensitivity sensitivity_;
  double elapsed_ = 0.0;
  int samples_ = 0;
  TwoLanes predicted_sum_;
  TwoLanes measured_sum_;
  Sensitivity sensitivity_sum_;
  // Process noise gathered by a and b: of the end, between the end and the sum, of the sum.
  Square noise_end_;
  Square noise_end_sum_;
  Square noise_sum_;
};

}  // namespace cvg
