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
  /// Of the measured theta and phi, each times a, white, two-sided [V^2 s]. The angles are inputs
  /// of the model: their noise acts on a' and b' through the derivatives of these rates.
  double angle_density = 0.0;
};

/// Outcome of one update.
struct IntervalUpdate {
  /// false: a number was not finite, the covariance of the measurement not positive definite, a
  /// variance below zero, or there was no sample; then nothing was changed
  bool accepted = false;
  Eigen::Vector2d innovation = Eigen::Vector2d::Zero();             ///< of the mean a, b [V]
  Eigen::Matrix2d innovation_covariance = Eigen::Matrix2d::Zero();  ///< [V^2]
  double normalised_innovation_squared = 0.0;
};

/// Extended Kalman filter for the state (29) that uses the mean of a and b over an interval as one
/// measurement. docs/filter.md derives it, with the letters given below.
///
/// Within the interval the filter predicts a and b step by step, together with their derivatives
/// with respect to the state at the interval's start. So every block counts, but the covariance
/// changes only once per interval. The parameters are constant within it, so only the rows of a and
/// b of the transition differ from the identity. Process noise enters the end state, the mean and
/// the covariance between them. An interval of one sample is an ordinary filter step, that of
/// PaperFilter.
///
/// The covariance is kept in two parts: that of a and b given the parameters, and the factored
/// covariance of the parameters. A step changes only the first, because the parameters do not move,
/// and no measurement can make a variance of the parameters negative.
class IntervalFilter {
 public:
  /// `step_duration`: of each step [s].
  IntervalFilter(const AveragedModel& model, const IntervalNoise& noise, double step_duration);

  /// Forgets everything and starts an interval. value[kDriveGain], not zero, sets the scale of ks;
  /// `walk`: random walk of the parameters [unit of the parameter / sqrt(s)]. `memory_time`: age at
  /// which data count for 1/e; 0: the filter does not forget [s].
  void initialise(const StateVector& value, const StateVector& sigma, const ParameterVector& walk,
                  double memory_time = 0.0);
  /// Forgets a and b and keeps the parameters; a and b become `axes` with standard deviation
  /// `sigma` [V] each, without correlations. Starts an interval.
  void restartAxes(const Eigen::Vector2d& axes, double sigma);

  /// Whether the next `steps` steps are linear enough for one interval: what the derivatives leave
  /// out, products of the uncertainties of axes and parameters, stays below a tenth of the noise of
  /// the mean (docs/filter.md, section 7). `reference_frequency`: w [rad/s].
  bool isLinearOver(int steps, double reference_frequency) const;

  /// Adds the (a, b) [V] measured at the start of the interval.
  void sample(const Eigen::Vector2d& measured);
  /// Adds a step and the (a, b) [V] measured at its end. Steps wait in the filter's queue until
  /// enough can be taken side by side, or until the interval ends. Each is predicted by itself.
  /// Derivatives and noise only weigh the innovation; they are those of one step over up to 8
  /// steps, at the mean of their dynamics.
  void step(const AveragedStep<double>& step, const Eigen::Vector2d& measured);
  /// Takes the steps that wait in the queue.
  void settle();
  /// Ends the interval with its update and starts the next. The result is valid until the next
  /// update.
  const IntervalUpdate& update();
  /// A step() and an update() in one, at half the cost.
  const IntervalUpdate& stepAndUpdate(const AveragedStep<double>& step,
                                      const Eigen::Vector2d& measured);
  const IntervalUpdate& lastUpdate() const { return update_; }
  /// Goes back to the start of the interval and drops what it has gathered.
  void abandon();

  /// State at the end of the last interval.
  StateVector value() const;
  StateMatrix covariance() const;
  /// The variances of the parameters, from the diagonal of covariance().
  ParameterVector parameterVariance() const;

 private:
  /// r = (a, b) and the parameters p with their errors. The error of r is `regression` times the
  /// error of p, plus a rest (docs/filter.md, section 2).
  struct Belief {
    Vector2 axes;                   ///< r
    Vector5 parameters;             ///< p
    FactoredCovariance covariance;  ///< P, of p
    Matrix2x5 regression;           ///< C
    Matrix2 conditional;            ///< S, covariance of r given p
  };
  /// How the end of an interval, or the sum of its samples, depends on the state at its start.
  struct Sensitivity {
    Matrix2 by_axes;          ///< T
    Matrix2x5 by_parameters;  ///< G
  };
  /// Covariance of the process noise: of r at the end of an interval (N_e), between r at the end
  /// and the sum of the samples (N_es), of the sum (N_s).
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
  // The present belief, and the next one: it becomes present when all its numbers are known to be
  // finite.
  Belief beliefs_[2];
  int present_ = 0;
  IntervalUpdate update_;
  ParameterVector variance_growth_;  // of the parameters [unit of the parameter^2 / s]
  bool walks_ = false;
  double memory_time_ = 0.0;  // 0: does not forget

  // The running interval. Its sums are set to zero by its first sample or step (start()).
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
