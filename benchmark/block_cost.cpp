// What one block of the loops, or of the identifier, costs in instructions: work for an emulator
// that counts them (scripts/checks/arm.sh).
//
//   block_cost loops|identifier|identifier_each_block BLOCKS
//
// prepares everything, brings the part to where it runs for hours and hands it BLOCKS blocks more
// (as many as are prepared at most), so that the difference between two runs is that of the blocks
// alone.

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <stdexcept>
#include <string>
#include <vector>

#include "identification/averaged_loop.h"
#include "ring_gyro/common/angle.h"
#include "ring_gyro/control/control_loops.h"
#include "ring_gyro/identification/filter/identifier.h"

namespace cvg {
namespace {

constexpr int kMostBlocks = 200;

/// An orbit at rest as the converter sees it: 1 ms holds whole cycles of 14 kHz, so that all blocks
/// have the same samples, and the loops find every one where it should be.
DisplacementBlock blockOfOrbit(const ConverterParameters& converter, double frequency) {
  const Envelope envelope = envelopeFromOrbit({1.0, 0.0, 0.4, -0.5 * kPi});
  DisplacementBlock block;
  block.stamp = {1, 0, 0, converter.blockDurationNanoseconds()};
  for (std::int64_t j = 0; j < converter.block_samples; ++j) {
    const std::complex<double> turn =
        std::polar(1.0, kTwoPi * frequency * static_cast<double>(j) * converter.samplePeriod());
    block.x.push_back((envelope[0] * turn).real());
    block.y.push_back((envelope[1] * turn).real());
  }
  return block;
}

/// Demodulation, orbit, the four loops with their learning, steering, drive: all of ControlLoops.
void runLoops(int blocks) {
  constexpr int kUntilLocked = 100;
  DeviceKnowledge device;
  device.natural_frequency = 14e3;
  device.quality_factor = 22000.0;
  device.drive_gain = 1.1e5;
  ControlParameters control;
  control.virtual_rate = toRadians(12.0);
  const ConverterParameters converter;
  ControlLoops loops(device, control, {}, converter);
  DisplacementBlock block = blockOfOrbit(converter, device.natural_frequency);
  block.reference_frequency = kTwoPi * device.natural_frequency;
  bool locked = false;
  for (int n = 0; n < kUntilLocked + blocks; ++n) {
    block.stamp.end_ns += block.stamp.duration_ns;
    const LoopOutput& output = loops.process(block);
    locked = output.elements.status.locked();
    block.drive_answers_sequence = output.command.answers_sequence;
    block.driven = true;
    block.reference_phase = output.command.reference_phase;
    block.reference_frequency = output.command.reference_frequency;
    ++block.stamp.sequence;
  }
  if (!locked)
    throw std::runtime_error("the loops have not locked: what was counted is the way there");
}

/// An identifier that knows the device so well already that it takes whole periods.
void runIdentifier(int blocks, double period) {
  constexpr int kUntilRunning = 300;
  IdentificationParameters parameters;
  parameters.update_period = period;
  parameters.initial_gamma_sigma = 1e-4;
  parameters.initial_mu_sigma = 1e-8;
  parameters.initial_drive_gain_sigma = 1e-4;
  AveragedLoop loop({});
  std::vector<AveragedLoop::Output> outputs;
  for (int n = 0; n < kUntilRunning + kMostBlocks; ++n) outputs.push_back(loop.step());
  Identifier identifier(AveragedLoop::Options{}.known, parameters, {});
  bool updated = false;
  for (int n = 0; n < kUntilRunning + blocks; ++n) {
    const AveragedLoop::Output& output = outputs[static_cast<std::size_t>(n)];
    const ParameterEstimate* estimate = identifier.process(output.elements, output.gains);
    if (estimate != nullptr) updated = estimate->updated;
  }
  if (!updated) throw std::runtime_error("the identifier has made no update");
}

void run(const std::string& part, int blocks) {
  if (blocks < 0 || blocks > kMostBlocks) {
    throw std::invalid_argument("BLOCKS is from 0 to " + std::to_string(kMostBlocks));
  }
  if (part == "loops") {
    runLoops(blocks);
  } else if (part == "identifier") {
    runIdentifier(blocks, 0.1);
  } else if (part == "identifier_each_block") {
    runIdentifier(blocks, 1e-3);
  } else {
    throw std::invalid_argument("there is no " + part +
                                ": loops, identifier or identifier_each_block");
  }
}

}  // namespace
}  // namespace cvg

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: block_cost loops|identifier|identifier_each_block BLOCKS\n");
    return 2;
  }
  try {
    cvg::run(argv[1], std::atoi(argv[2]));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "block_cost: %s\n", error.what());
    return 1;
  }
}
