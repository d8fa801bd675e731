#pragma once

#include <Eigen/Core>
#include <vector>

#include "identification/averaged_loop.h"
#include "ring_gyro/identification/filter/interval_filter.h"
#include "ring_gyro/identification/model/averaged_model.h"
#include "ring_gyro/signals/parameter_estimate.h"

namespace cvg {

/// One step of a filter with the sample at its end.
struct RecordedStep {
  double theta;
  double phi;
  AveragedInput input;
  Eigen::Vector2d measured;
};

/// The locked loop of AveragedLoop without delay, one step at a time.
class RecordedLoop {
 public:
  static constexpr double kStep = 1e-3;  // [s]

  /// `noise_density`: of the displacements, one-sided [V/sqrt(Hz)].
  explicit RecordedLoop(double noise_density, unsigned seed = 1)
      : loop_(options(noise_density, seed)), before_(loop_.orbit()) {}

  RecordedStep next() {
    const AveragedLoop::Output output = loop_.step();
    const Orbit& now = output.elements.orbit;
    RecordedStep step;
    step.theta = 0.5 * (before_.theta + now.theta);
    step.phi = 0.5 * (before_.phi + now.phi);
    step.input.drive = output.gains.drive.total();
    step.input.reference_frequency = output.gains.reference_frequency;
    step.input.pattern_rate = (now.theta - before_.theta) / kStep;
    step.measured = {now.a, now.b};
    before_ = now;
    return step;
  }

  std::vector<RecordedStep> next(std::size_t steps) {
    std::vector<RecordedStep> record(steps);
    for (RecordedStep& step : record) step = next();
    return record;
  }

  // The knowledge that a filter of this loop gets.

  static DeviceKnowledge known() { return AveragedLoop::Options().known; }
  /// `process`: of a' and b' [V/sqrt(s)].
  static IntervalNoise noise(double density, double process) {
    IntervalNoise noise;
    noise.sample_variance = density * density / kStep;
    noise.axes_density = process * process;
    noise.angle_density = density * density;
    return noise;
  }
  static StateVector startValue() {
    return (StateVector() << 1.0, 0.0, 0.0, 0.0, -25e-6, -45e-6, 1.05e5).finished();
  }
  static StateVector startSigma() {
    return (StateVector() << 1e-3, 1e-3, 0.05, 0.05, 1e-5, 1e-5, 1e4).finished();
  }

 private:
  static AveragedLoop::Options options(double noise_density, unsigned seed) {
    AveragedLoop::Options options;
    options.noise_density = noise_density;
    options.seed = seed;
    return options;
  }

  AveragedLoop loop_;
  Orbit before_;
};

}  // namespace cvg
