#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "ring_gyro/common/converter_parameters.h"
#include "ring_gyro/identification/filter/block_chain.h"
#include "ring_gyro/identification/model/averaged_model.h"
#include "ring_gyro/identification/model/envelope_model.h"
#include "ring_gyro/signals/parameter_estimate.h"

namespace cvg {

/// Covariance of the best estimator of a state whose first part moves linearly and whose rest is
/// constant: the recursion of the posterior Cramer-Rao bound. It needs no data, only the
/// derivatives at the truth. Does not allocate.
class InformationBound {
 public:
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 4, kMostExtendedStates>;

  /// `prior`: covariance before any data, with a positive diagonal; `moving`: states at its head
  /// that move, at most 4.
  InformationBound(const ExtendedMatrix& prior, Eigen::Index moving);

  /// One step of the moving states: `rows` is the derivative of each with respect to the whole
  /// state before the step; process noise adds `variance` to each.
  void step(const Rows& rows, double variance);
  /// Measurements with these derivatives with respect to the state, each with this variance.
  void measure(const Rows& rows, double variance);
  /// Replaces the knowledge of the moving states: `sigma` each, without correlations.
  void forgetMoving(double sigma);

  ExtendedMatrix covariance() const;

 private:
  Eigen::Index moving_;
  ExtendedVector scale_;
  ExtendedMatrix covariance_;  // of the scaled state
};

/// Bound for (a, b, gamma1, gamma2, mu1, mu2, ks) from every block's a and b; the angles and Q are
/// known.
class AxesBound {
 public:
  /// `prior_sigma`: of the seven states; `noise_density` one-sided [V/sqrt(Hz)]; `process_noise` of
  /// a' and b' [V/sqrt(s)].
  AxesBound(const AveragedModel& model, const DeviceParameters& truth,
            const StateVector& prior_sigma, double noise_density, double process_noise,
            const ConverterParameters& converter);

  /// The next block of the experiment; noise of the elements has only a second-order effect.
  void process(const OrbitalElements& elements, const ControlGains& gains);
  StateMatrix covariance() const;

 private:
  AveragedModel model_;
  DeviceParameters truth_;
  double sample_variance_;
  double rate_density_;
  BlockChain chain_;
  InformationBound bound_;
  Eigen::Vector2d axes_ = Eigen::Vector2d::Zero();  // by the model at the truth
  bool chained_ = false;
};

/// Bound for the states of the extended identifier from every block's a, b, theta and phi.
class EnvelopeBound {
 public:
  /// `truth` and `prior_sigma` in physical coordinates, in the order of the names of `model`; the
  /// envelope in `truth` is not used. Noise as in AxesBound.
  EnvelopeBound(const EnvelopeModel& model, const ExtendedVector& truth,
                const ExtendedVector& prior_sigma, double noise_density, double process_noise,
                const ConverterParameters& converter);

  /// The next block of the experiment; `rotation_rate`: k Om in it, as far as it is known [rad/s].
  void process(const OrbitalElements& elements, const ControlGains& gains,
               double rotation_rate = 0.0);
  /// Physical coordinates.
  ExtendedMatrix covariance() const;

 private:
  EnvelopeModel model_;
  ExtendedVector truth_;  // linear coordinates; the envelope moves by the model
  double sample_variance_;
  double rate_density_;
  BlockChain chain_;
  InformationBound bound_;
  bool chained_ = false;
  EnvelopeStep step_;
};

}  // namespace cvg
