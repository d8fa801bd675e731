#pragma once

#include <Eigen/Core>

#include "ring_gyro/common/small_algebra.h"
#include "ring_gyro/identification/filter/factored_covariance.h"
#include "ring_gyro/identification/filter/step_queue.h"
#include "ring_gyro/identification/model/averaged_model.h"
#include "ring_gyro/identification/model/averaged_step.h"
#include "ring_gyro/identification/model/axes_equation.h"
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
/// measurement. docs/filter.md derives it; PaperFilter is the same filter with full matrices.
///
/// Within the interval it carries the predicted axes and their derivatives with respect to the
/// state at the interval's start from step to step, so nothing is decimated and the covariance is
/// changed once an interval. Parameters stay constant within it, so only the rows of a and b of the
/// transition differ from identity. Process noise enters the end state, the mean and their
/// covariance exactly. An interval of one sample is an ordinary filter step.
///
/// The covariance is kept as that of a and b given the parameters, and as the factored covariance
/// of the parameters. Parameters do not move, so a step changes the former only, and no update can
/// make a variance negative.
class IntervalFilter {
 public:
  /// `step_duration`: of each step [s].
  IntervalFilter(const AveragedModel& model, const IntervalNoise& noise, double step_duration);

  /// Forgets everything and starts an interval. value[kDriveGain], not zero, sets the scale of ks;
  /// `walk`: random walk of the parameters [unit of the parameter / sqrt(s)]. `memory_time`: after
  /// which data count for 1/e, 0: they count for ever [s].
  void initialise(const StateVector& value, const StateVector& sigma, const ParameterVector& walk,
                  double memory_time = 0.0);
  /// Forgets a and b, keeps the parameters: `axes` with standard deviation `sigma` [V], correlated
  /// with nothing. Starts an interval.
  void restartAxes(const Eigen::Vector2d& axes, double sigma);

  /// Whether one interval of so many steps from here on is linear enough: what the derivatives
  /// leave out, products of the uncertainties of axes and parameters, stays under a tenth of the
  /// noise of the mean (docs/filter.md, section 7). `reference_frequency`: w [rad/s].
  bool isLinearOver(int steps, double reference_frequency) const;

  /// Adds a measured (a, b) [V] where the interval begins.
  void sample(const Eigen::Vector2d& measured);
  /// A step and the (a, b) [V] measured at its end. It waits in the filter's queue until there are
  /// enough to be taken side by side, or the interval ends. Each is predicted by itself;
  /// derivatives and noise, which only weigh the innovation, are those of one step over up to 8 at
  /// their mean.
  void step(const AveragedStep<double>& step, const Eigen::Vector2d& measured);
  /// Takes the steps that wait.
  void settle();
  /// Ends the interval with its update and starts the next. The result is good until the next
  /// update.
  const IntervalUpdate& update();
  /// A step() and an update() in one, at half the cost.
  const IntervalUpdate& stepAndUpdate(const AveragedStep<double>& step,
                                      const Eigen::Vector2d& measured);
  const IntervalUpdate& lastUpdate() const { return update_; }
  /// Drops what the interval has gathered: back to its start.
  void abandon();

  /// State at the end of the last interval.
  StateVector value() const;
  StateMatrix covariance() const;
  /// Diagonal of the covariance, as far as the parameters have it.
  ParameterVector parameterVariance() const;

 private:
  /// r = (a, b) and the parameters p with their errors: that of r is `regression` times that of p,
  /// and a rest (docs/filter.md, section 2).
  struct Belief {
    Vector2 axes;                   ///< r
    Vector5 parameters;             ///< p
    FactoredCovariance covariance;  ///< P, of p
    Matrix2x5 regression;           ///< C
    Matrix2 conditional;            ///< S, of r given p
  };
  /// How the end of an interval, or the sum of its samples, depends on the state at its start.
  struct Sensitivity {
    Matrix2 by_axes;          ///< T
    Matrix2x5 by_parameters;  ///< G
  };
  /// Process noise of r at the end of an interval (N_e), between that and the sum of the samples
  /// (N_es), of the sum (N_s).
  struct Noise {
    Matrix2 end, end_sum, sum;
  };

  StateVector variance() const;
  const Belief& present() const { return beliefs_[present_]; }
  DeviceParameters device() const;
  void start();
  Vector2 advance(const AxesDynamics<double>& mean, const Vector2& squares, int count);
  void gatherNoise(const Matrix2& transition, const Matrix2& to_sum, const Matrix2& noise,
                   double n);
  double angleVariance(const Vector2& axes) const;
  Matrix2 stepNoise(const AxesStepResult& step, const Vector2& axes) const;
  Vector5 measureParameters(const Matrix2x5& regression, const Matrix2& conditional,
                            const Vector2& innovation, FactoredCovariance& next);
  void measureStep(const AxesStepResult& step, const Matrix2& noise, const Vector2& innovation,
                   Belief& next);
  void measureMean(Belief& next);
  void keep(const Matrix2x5& shown);
  void walk(Belief& belief) const;
  void forget(const Matrix2x5& shown, Belief& belief) const;
  static void addTo(Belief& belief, double weight, const ParameterVector& direction);

  AveragedModel model_;
  IntervalNoise noise_;
  double step_duration_;  // h [s]
  double drive_gain_scale_ = 1.0;
  // The present one and room for the next, which counts once all its numbers are known to be
  // finite.
  Belief beliefs_[2];
  int present_ = 0;
  IntervalUpdate update_;
  ParameterVector variance_growth_;  // of the parameters [unit of the parameter^2 / s]
  bool walks_ = false;
  double memory_time_ = 0.0;  // 0: for ever

  // The running interval. What it gathers is set by its first sample or step.
  StepQueue waiting_;
  Vector2 axes_;
  double elapsed_ = 0.0;
  int samples_ = 0;
  Vector2 predicted_sum_;
  Vector2 measured_sum_;
  Sensitivity to_end_;
  Sensitivity to_sum_;
  Noise gathered_;
};

}  // namespace cvg
