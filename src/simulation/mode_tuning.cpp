#include "ring_gyro/simulation/mode_tuning.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "ring_gyro/simulation/closed_loop.h"

namespace cvg {
namespace {

TuningPass identify(const LoopConfiguration& configuration, const TuningOptions& options) {
  const ResonatorParameters& ring = configuration.plant.resonator;
  const double period = configuration.converter.blockDuration();
  ClosedLoop loop(configuration);
  ParameterEstimate last;
  while (static_cast<double>(last.used_blocks) * period < options.identification_time) {
    const LoopRecord now = loop.step();
    if (now.estimate) last = *now.estimate;
    if (loop.time() > 10.0 * options.identification_time + 10.0) {
      throw std::runtime_error(
          "mode tuning: the loops do not stay locked with these voltages; check the drive limit "
          "and "
          "the quadrature that the split asks for");
    }
  }
  TuningPass pass;
  pass.squares = TuningSquares::of(ring);
  pass.mu1 = last.value[kMu1];
  pass.mu2 = last.value[kMu2];
  pass.sigma = std::max(last.sigma(kMu1), last.sigma(kMu2));
  pass.split = configuration.device.natural_frequency * std::hypot(pass.mu1, pass.mu2);
  const ResonatorParameters tuned = ring.tuned();
  pass.true_split = tuned.natural_frequency * std::hypot(tuned.mu1, tuned.mu2);
  return pass;
}

}  // namespace

TuningSquares TuningSquares::of(const ResonatorParameters& ring) {
  const auto square = [](double volt) { return volt * volt; };
  return {square(ring.tuning_voltage_0) - square(ring.tuning_voltage_90),
          square(ring.tuning_voltage_45) - square(ring.tuning_voltage_135)};
}

void TuningSquares::applyTo(ResonatorParameters& ring) const {
  ring.tuning_voltage_0 = std::sqrt(std::max(0.0, along));
  ring.tuning_voltage_90 = std::sqrt(std::max(0.0, -along));
  ring.tuning_voltage_45 = std::sqrt(std::max(0.0, across));
  ring.tuning_voltage_135 = std::sqrt(std::max(0.0, -across));
}

void TuningOptions::declare(ParameterTable& table) {
  table
      .number("gain", assumed_tuning_gain, "1/V^2", Range::above(0.0),
              "softening of a tuning electrode relative to w0^2")
      .number("time", identification_time, "s", Range::between(1.0, 1e6),
              "of identification a pass, after the lock")
      .number("target", target_split, "Hz", Range::above(0.0), "split to reach")
      .integer("passes", most_passes, Range::between(1, 1000), "at the most");
}

std::vector<TuningPass> tuneModes(LoopConfiguration configuration, const TuningOptions& options,
                                  const std::function<void(const TuningPass&)>& seen) {
  if (!(options.assumed_tuning_gain > 0.0)) {
    throw std::invalid_argument(
        "mode tuning: assumed_tuning_gain must be above zero; it is C / (d^2 m w0^2) of a tuning "
        "electrode");
  }
  double gain = options.assumed_tuning_gain;
  std::vector<TuningPass> passes;
  for (std::int64_t number = 0; number < options.most_passes; ++number) {
    const TuningPass pass = identify(configuration, options);
    passes.push_back(pass);
    if (seen) seen(pass);
    if (pass.split < options.target_split) break;
    if (passes.size() > 1) {
      // Effect of the last change of the voltages, along its own direction.
      const TuningPass& before = passes[passes.size() - 2];
      const Eigen::Vector2d change(pass.squares.along - before.squares.along,
                                   pass.squares.across - before.squares.across);
      const Eigen::Vector2d effect(before.mu1 - pass.mu1, before.mu2 - pass.mu2);
      const double seen_gain = 2.0 * effect.dot(change) / change.squaredNorm();
      if (seen_gain > 0.0) gain = seen_gain;
    }
    TuningSquares squares = pass.squares;
    squares.along += 2.0 * pass.mu1 / gain;
    squares.across += 2.0 * pass.mu2 / gain;
    squares.applyTo(configuration.plant.resonator);
  }
  return passes;
}

}  // namespace cvg
