// The identifier's filter against a dense one: time per step, and accuracy.

#include "filter_benchmark.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <vector>

#include "identification/recorded_loop.h"
#include "interleaved.h"
#include "ring_gyro/identification/filter/interval_filter.h"
#include "ring_gyro/identification/filter/paper_filter.h"

namespace cvg {
namespace {

constexpr double kDensity = 5e-6;  // of the displacements, one-sided [V/sqrt(Hz)]

IntervalNoise noise() { return RecordedLoop::noise(kDensity, 2e-6); }

IntervalFilter makeFilter() {
  IntervalFilter filter(AveragedModel(RecordedLoop::known()), noise(), RecordedLoop::kStep);
  filter.initialise(RecordedLoop::startValue(), RecordedLoop::startSigma(),
                    ParameterVector::Zero());
  return filter;
}

template <typename Real>
PaperFilter<Real> makePaperFilter() {
  return {RecordedLoop::known(), noise(), RecordedLoop::startValue(), RecordedLoop::startSigma()};
}

void step(IntervalFilter& filter, const RecordedStep& record) {
  benchmark::DoNotOptimize(
      filter.stepAndUpdate(averagedStep(record.theta, record.phi, record.input), record.measured));
}

template <typename Real>
void step(PaperFilter<Real>& filter, const RecordedStep& record) {
  filter.predict(record.theta, record.phi, record.input, RecordedLoop::kStep);
  filter.correct(record.measured);
}

}  // namespace

void filterAgainstDense(benchmark::State& state) {
  constexpr std::size_t kSteps = 10000;
  const std::vector<RecordedStep> records = RecordedLoop(kDensity).next(kSteps);
  IntervalFilter filter = makeFilter();
  PaperFilter<double> dense = makePaperFilter<double>();
  timeInTurns(
      state, threadTime, kSteps,
      [&] {
        for (const RecordedStep& record : records) step(filter, record);
      },
      kSteps,
      [&] {
        for (const RecordedStep& record : records) step(dense, record);
      });
  if (!filter.value().allFinite() || !dense.value().allFinite()) {
    throw std::runtime_error("a filter has left the finite numbers");
  }
}

void filterAccuracy(benchmark::State& state, std::int64_t steps) {
  double worst = 0.0;
  double worst_sigma = 0.0;
  for (auto _ : state) {
    RecordedLoop source(kDensity);
    IntervalFilter filter = makeFilter();
    PaperFilter<long double> reference = makePaperFilter<long double>();
    for (std::int64_t n = 0; n < steps; ++n) {
      const RecordedStep record = source.next();
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
