#include "ring_gyro/simulation/calibration_judgement.h"

#include <Eigen/Core>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "ring_gyro/analysis/rate_harmonics.h"
#include "ring_gyro/calibration/rate_parity.h"
#include "ring_gyro/common/angle.h"
#include "ring_gyro/demodulation/orbit.h"
#include "ring_gyro/simulation/closed_loop.h"

namespace cvg {
namespace {

constexpr double kLockTime =
    30.0;  // limit for ring-up and lock: decay times, but at least this [s]

struct Run {
  std::vector<AngleSample> output;
  std::vector<double> true_theta;  // at the times of `output` [rad]
};

/// Time in which the pattern makes a turn and a quarter, which the harmonics need [s].
double turnTime(const LoopConfiguration& configuration, double rate) {
  const double pattern_rate = configuration.plant.resonator.angular_gain * std::abs(rate);
  if (pattern_rate > 0.0) return 1.25 * kTwoPi / pattern_rate;
  throw std::invalid_argument(
      "judgement: the pattern does not turn: the rate or "
      "resonator/angular_gain is zero");
}

Run turn(const LoopConfiguration& configuration, double time,
         const std::function<void(double)>& progress) {
  ClosedLoop loop(configuration);
  const double decay = configuration.device.decayRate();
  const double settling = std::max(10.0, 10.0 / decay);
  double settled = 0.0;
  Run run;
  AngleUnwrapper unwrapper;
  double before = 0.0;
  while (settled < settling + time) {
    const LoopRecord now = loop.step();
    const OrbitalElements& elements = now.loops.elements;
    const double block = elements.stamp.duration();
    const double truth = unwrapper.unwrap(orbitFromEnvelope(now.truth().envelope).theta);
    const bool usable = elements.status.usable();
    settled = usable ? settled + block : settled;
    if (usable && settled > settling) {
      // Elements are a group delay old; the truth is of the end of the block.
      const double back = elements.group_delay / block;
      run.output.push_back({elements.stamp.end() - elements.group_delay, elements.angle});
      run.true_theta.push_back(truth + back * (before - truth));
    }
    before = truth;
    if (loop.time() > settled + std::max(kLockTime, kLockTime / decay)) {
      throw std::runtime_error("judgement: the loops do not stay locked");
    }
    if (progress) progress(settled / (settling + time));
  }
  return run;
}

/// Harmonics of output - truth against the truth.
AngleHarmonics angleError(const std::vector<const Run*>& runs) {
  constexpr int kOrders = RateHarmonics::kCount;
  constexpr int kTerms = 2 * kOrders;
  // One unknown offset per run, because each run counts angles from its own start.
  const Eigen::Index unknowns = kTerms + static_cast<Eigen::Index>(runs.size());
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(unknowns, unknowns);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(unknowns);
  Eigen::VectorXd row(unknowns);
  for (std::size_t r = 0; r < runs.size(); ++r) {
    const Run& run = *runs[r];
    for (std::size_t i = 0; i < run.output.size(); ++i) {
      row.setZero();
      for (int n = 1; n <= kOrders; ++n) {
        row[n - 1] = std::cos(n * run.true_theta[i]);
        row[kOrders + n - 1] = std::sin(n * run.true_theta[i]);
      }
      row[kTerms + static_cast<Eigen::Index>(r)] = 1.0;
      normal.selfadjointView<Eigen::Lower>().rankUpdate(row);
      right += (run.output[i].theta - run.true_theta[i]) * row;
    }
  }
  normal.triangularView<Eigen::StrictlyUpper>() = normal.transpose();
  const Eigen::VectorXd solution = normal.colPivHouseholderQr().solve(right);
  AngleHarmonics error;
  for (int n = 0; n < kOrders; ++n) {
    error.cosine.push_back(solution[n]);
    error.sine.push_back(solution[kOrders + n]);
  }
  return error;
}

double largestSlope(const AngleHarmonics& function) {
  double largest = 0.0;
  for (int i = 0; i < 1440; ++i) {
    largest = std::max(largest, std::abs(function.slopeAt(kTwoPi * i / 1440)));
  }
  return largest;
}

}  // namespace

CalibrationJudgement judgeCalibration(LoopConfiguration configuration, double rate, double time,
                                      const std::function<void(double)>& progress) {
  configuration.control.virtual_rate = 0.0;
  configuration.plant.rotation = RotationParameters();
  time = std::max(time, turnTime(configuration, rate));
  const auto part = [&](double done_before) -> std::function<void(double)> {
    if (!progress) return {};
    return [&progress, done_before](double done) { progress(done_before + 0.5 * done); };
  };
  configuration.plant.rotation.rate = rate;
  const Run forward = turn(configuration, time, part(0.0));
  configuration.plant.rotation.rate = -rate;
  const Run backward = turn(configuration, time, part(0.5));

  const double block = configuration.converter.blockDuration();
  const RateHarmonics ahead =
      fitRateHarmonics(forward.output, windowOfTurns(forward.output, block));
  const RateHarmonics back =
      fitRateHarmonics(backward.output, windowOfTurns(backward.output, block));
  CalibrationJudgement judgement;
  judgement.rate = rate;
  const double gain = configuration.device.angular_gain;
  judgement.forward_peak = ahead.peak_to_peak / gain;
  judgement.backward_peak = back.peak_to_peak / gain;
  judgement.drift = scaled(evenPart(ahead, back), 1.0 / gain);
  judgement.drift_peak_to_peak = peakToPeak(judgement.drift);
  judgement.threshold = std::abs(largestMagnitude(judgement.drift).value);
  judgement.angle_error = angleError({&forward, &backward});
  judgement.slope_error = largestSlope(judgement.angle_error);
  return judgement;
}

}  // namespace cvg
