// The identifier's filter against a dense one: time a step, and what it does to the accuracy.

#include "filter_benchmark.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <vector>

#include "identification/averaged_loop.h"
#include "interleaved.h"
#include "ring_gyro/identification/filter/interval_filter.h"
#include "ring_gyro/identification/filter/paper_filter.h"

namespace cvg {
namespace {

constexpr double kFrequency = 14e3;
constexpr double kQuality = 22000.0;
constexpr double kStep = 1e-3;
constexpr double kDensity = 5e-6;

/// One step of the filter with the sample at its end.
struct Record {
  double theta;
  double phi;
  AveragedInput input;
  Eigen::Vector2d measured;
};

/// The noisy locked loop at 1 kHz, a step at a time.
class RecordSource {
 public:
  RecordSource() : loop_(options()), before_(loop_.orbit()) {}

  Record next() {
    const AveragedLoop::Output output = loop_.step();
    const Orbit& now = output.elements.orbit;
    Record record;
    record.theta = 0.5 * (before_.theta + now.theta);
    record.phi = 0.5 * (before_.phi + now.phi);
    record.input.drive = output.gains.drive.total();
    record.input.reference_frequency = output.gains.reference_frequency;
    record.input.pattern_rate = (now.theta - before_.theta) / kStep;
    record.measured = {now.a, now.b};
    before_ = now;
    return record;
  }

 private:
  static AveragedLoop::Options options() {
    AveragedLoop::Options options;
    options.noise_density = kDensity;
    return options;
  }

  AveragedLoop loop_;
  Orbit before_;
};

IntervalNoise noise() {
  IntervalNoise noise;
  noise.sample_variance = kDensity * kDensity / kStep;
  noise.axes_density = 2e-6 * 2e-6;
  noise.angle_density = kDensity * kDensity;
  return noise;
}

StateVector startValue() {
  StateVector value;
  value << 1.0, 0.0, 0.0, 0.0, -25e-6, -45e-6, 1.05e5;
  return value;
}

StateVector startSigma() {
  StateVector sigma;
  sigma << 1e-3, 1e-3, 0.05, 0.05, 1e-5, 1e-5, 1e4;
  return sigma;
}

IntervalFilter makeFilter() {
  IntervalFilter filter(AveragedModel({kFrequency, kQuality}), noise());
  filter.initialise(startValue(), startSigma(), ParameterVector::Zero());
  return filter;
}

void step(IntervalFilter& filter, const Record& record) {
  benchmark::DoNotOptimize(filter.stepAndUpdate(
      averagedStep(record.theta, record.phi, record.input), kStep, record.measured));
}

template <typename Real>
void step(PaperFilter<Real>& filter, const Record& record) {
  filter.predict(record.theta, record.phi, record.input, kStep);
  filter.correct(record.measured);
}

}  // namespace

void filterAgainstDense(benchmark::State& state) {
  constexpr std::size_t kSteps = 10000;
  RecordSource source;
  std::vector<Record> records(kSteps);
  for (Record& record : records) record = source.next();
  IntervalFilter filter = makeFilter();
  PaperFilter<double> dense({kFrequency, kQuality}, noise(), startValue(), startSigma());
  timeInTurns(
      state, threadTime, kSteps,
      [&] {
        for (const Record& record : records) step(filter, record);
      },
      kSteps,
      [&] {
        for (const Record& record : records) step(dense, record);
      });
  if (!filter.value().allFinite() || !dense.value().allFinite()) {
    throw std::runtime_error("a filter has left the finite numbers");
  }
}

void filterAccuracy(benchmark::State& state, std::int64_t steps) {
  double worst = 0.0;
  double worst_sigma = 0.0;
  for (auto _ : state) {
    RecordSource source;
    IntervalFilter filter = makeFilter();
    PaperFilter<long double> reference({kFrequency, kQuality}, noise(), startValue(), startSigma());
    for (std::int64_t n = 0; n < steps; ++n) {
      const Record record = source.next();
      step(filter, record);
      step(reference, record);
      const StateMatrix covariance = filter.covariance();
      for (int k = 0; k < 7; ++k) {
        const double sigma = static_cast<double>(reference.sigma(k));
        worst = std::max(
            worst, std::abs(static_cast<double>(filter.value()[k] - reference.value()[k])) / sigma);
        worst_sigma = std::max(worst_sigma, std::abs(std::sqrt(covariance(k, k)) / sigma - 1.0));
      }
    }
  }
  state.counters["worst_state"] = worst;
  state.counters["worst_sigma"] = worst_sigma;
}

}  // namespace cvg
