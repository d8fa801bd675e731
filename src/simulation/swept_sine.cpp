#include "ring_gyro/simulation/swept_sine.h"

#include <cmath>
#include <complex>

#include "ring_gyro/common/angle.h"
#include "ring_gyro/signals/envelope.h"

namespace cvg {
namespace {

constexpr std::int64_t kStart = 1000000000;  // [ns]; any time except zero

// The device on a bench. Input: a drive phasor. Output: one envelope per block.
class OpenLoop {
 public:
  OpenLoop(const PlantParameters& plant, const ConverterParameters& converter,
           const DemodulationParameters& demodulation, double frequency, std::uint64_t seed)
      : plant_(plant, converter, seed, 1, kStart),
        demodulator_(demodulation, converter, frequency),
        period_(converter.blockDuration()),
        block_(&plant_.start()) {}

  Envelope step(const Envelope& drive, double frequency) {
    DriveCommand command;
    command.answers_sequence = block_->stamp.sequence;
    command.reference_phase =
        wrapToPi(block_->reference_phase + block_->reference_frequency * period_);
    command.reference_frequency = kTwoPi * frequency;
    command.envelope = drive;
    block_ = &plant_.step(command);
    return demodulator_.process(*block_);
  }
  int blocks(double time) const { return static_cast<int>(std::ceil(time / period_)); }

 private:
  PlantSimulator plant_;
  Demodulator demodulator_;
  double period_;
  const DisplacementBlock* block_;
};

Envelope along(int axis, double volts) {
  Envelope drive = Envelope::Zero();
  drive[axis] = volts;
  return drive;
}

}  // namespace

void SweepParameters::declare(ParameterTable& table) {
  table.number("centre", centre, "Hz", Range::atLeast(0.0), "of the sweep; 0: the device's f0")
      .number("span", span, "Hz", Range::above(0.0), "of the sweep about its centre")
      .integer("points", points, Range::between(5, 100000), "frequencies in the sweep")
      .number("drive", drive, "V", Range::above(0.0), "amplitude")
      .number("settling", settling, "s", Range::above(0.0),
              "wait at each frequency, twelve decay times or more")
      .number("averaging", averaging, "s", Range::above(0.0), "length of each measurement")
      .number("ring_down_time", ring_down_time, "s", Range::above(0.0),
              "recorded after the drive is switched off");
}

std::vector<FrequencyPoint> sweepSine(const PlantParameters& plant,
                                      const ConverterParameters& converter,
                                      const DemodulationParameters& demodulation,
                                      const SweepParameters& sweep, std::uint64_t seed,
                                      const Progress& progress) {
  std::vector<FrequencyPoint> points(static_cast<std::size_t>(sweep.points));
  for (int axis = 0; axis < 2; ++axis) {
    OpenLoop bench(plant, converter, demodulation, sweep.centre,
                   seed + static_cast<std::uint64_t>(axis));
    const Envelope drive = along(axis, sweep.drive);
    for (std::size_t k = 0; k < points.size(); ++k) {
      const double share = static_cast<double>(k) / static_cast<double>(points.size() - 1);
      points[k].frequency = sweep.centre + sweep.span * (share - 0.5);
      const int settling = bench.blocks(sweep.settling);
      for (int n = 0; n < settling; ++n) bench.step(drive, points[k].frequency);
      Envelope sum = Envelope::Zero();
      const int averaging = bench.blocks(sweep.averaging);
      for (int n = 0; n < averaging; ++n) sum += bench.step(drive, points[k].frequency);
      points[k].response.col(axis) = sum / (averaging * sweep.drive);
      if (progress) progress(0.5 * (axis + share));
    }
  }
  return points;
}

RingDown recordRingDown(const PlantParameters& plant, const ConverterParameters& converter,
                        const DemodulationParameters& demodulation, const SweepParameters& sweep,
                        std::uint64_t seed) {
  RingDown ring_down;
  ring_down.frequency = sweep.centre;
  ring_down.period = converter.blockDuration();
  for (int axis = 0; axis < 2; ++axis) {
    OpenLoop bench(plant, converter, demodulation, sweep.centre,
                   seed + static_cast<std::uint64_t>(axis));
    const int ring_up = bench.blocks(sweep.settling);
    for (int n = 0; n < ring_up; ++n) bench.step(along(axis, sweep.drive), sweep.centre);
    constexpr int kFilterBlocks = 4;  // blocks whose filter windows still contain driven samples
    for (int n = 0; n < kFilterBlocks; ++n) bench.step(along(axis, 0.0), sweep.centre);
    const int blocks = bench.blocks(sweep.ring_down_time);
    std::vector<Envelope> run;
    run.reserve(static_cast<std::size_t>(blocks));
    for (int n = 0; n < blocks; ++n) run.push_back(bench.step(along(axis, 0.0), sweep.centre));
    ring_down.runs.push_back(std::move(run));
  }
  return ring_down;
}

}  // namespace cvg
