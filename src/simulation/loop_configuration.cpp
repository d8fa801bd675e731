#include "ring_gyro/simulation/loop_configuration.h"

#include <chrono>
#include <cmath>

namespace cvg {
namespace {

// A parameter server carries 32-bit integers and message stamps unsigned 32-bit seconds.
constexpr double kLargestInteger = 2147483647.0;

template <typename Parameters>
Section section(const char* name, Parameters& parameters) {
  Section result{name, {}};
  parameters.declare(result.table);
  return result;
}

}  // namespace

std::int64_t RunParameters::startNanoseconds() const { return std::llround(1e9 * start_time); }

std::uint32_t RunParameters::sessionIdentifier() const {
  if (session != 0) return static_cast<std::uint32_t>(session);
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const auto tenths = std::chrono::duration_cast<std::chrono::milliseconds>(now).count() / 100;
  return static_cast<std::uint32_t>(tenths);
}

std::int64_t RunParameters::followingSession() const {
  if (session == 0) return 0;
  return session < static_cast<std::int64_t>(kLargestInteger) ? session + 1 : 1;
}

std::uint64_t RunParameters::blocks(const ConverterParameters& converter) const {
  if (duration <= 0.0) return 0;
  const double blocks = std::round(duration / converter.blockDuration());
  return blocks < 1.0 ? 1 : static_cast<std::uint64_t>(blocks);
}

void RunParameters::declare(ParameterTable& table) {
  table
      .number("duration", duration, "s", Range::between(0.0, 1e9),
              "simulated time of the run; 0: until stopped")
      .integer("seed", seed, Range::between(0.0, kLargestInteger), "of all noise")
      .integer(
          "session", session, Range::between(0.0, kLargestInteger),
          "tells one start of the plant from another, a plant node that is started again takes "
          "the next; 0: from the wall clock, which makes each run's messages its own")
      .number("start_time", start_time, "s", Range::between(1e-9, 2e9),
              "stamp of the start of the first block; never zero, which in ROS means no time");
}

void DeviceKnowledge::declare(ParameterTable& table) {
  // No ring has a Bryan factor above 1, but a rate table measures it together with its own scale
  // and with the second order of the pick-off's errors: what a calibration run writes must be
  // readable.
  constexpr double kLargestMeasuredGain = 1.1;
  table
      .requiredNumber("natural_frequency", natural_frequency, "Hz", Range::between(1.0, 10e6),
                      "f0, what the NCO starts from and the averaged model uses")
      .requiredNumber("quality_factor", quality_factor, "1", Range::between(10.0, 1e9),
                      "Q, for the loop gains and as the scale of identified damping and ks")
      .requiredNumber("drive_gain", drive_gain, "1/s^2", Range::above(0.0),
                      "ks as the loops assume it; the identifier finds its own")
      .number("angular_gain", angular_gain, "1", Range::between(0.01, kLargestMeasuredGain),
              "k, the Bryan factor, with which the pattern rate is reported as rate of the case");
}

Sections LoopConfiguration::sections() {
  Sections result;
  result.push_back(section("run", run));
  result.push_back(section("converter", converter));
  result.push_back(section("device", device));
  result.push_back(section("resonator", plant.resonator));
  result.push_back(section("sense", plant.sense));
  result.push_back(section("drive", plant.drive));
  result.push_back(section("rotation", plant.rotation));
  result.push_back(section("demodulation", demodulation));
  result.push_back(section("control", control));
  result.push_back(section("calibration", corrections));
  result.push_back(section("identification", identification));
  result.push_back(section("extended", extended));
  result.push_back(section("compensation", compensation));
  result.push_back(section("calibration_run", calibration_run));
  return result;
}

void LoopConfiguration::shareDevice() {
  control.natural_frequency = device.natural_frequency;
  control.quality_factor = device.quality_factor;
  control.drive_gain = device.drive_gain;
  identification.natural_frequency = device.natural_frequency;
  identification.quality_factor = device.quality_factor;
  extended.natural_frequency = device.natural_frequency;
  extended.quality_factor = device.quality_factor;
  compensation.natural_frequency = device.natural_frequency;
  compensation.quality_factor = device.quality_factor;
  calibration_run.natural_frequency = device.natural_frequency;
  calibration_run.quality_factor = device.quality_factor;
  calibration_run.drive_gain = device.drive_gain;
  calibration_run.angular_gain = device.angular_gain;
}

std::uint64_t LoopConfiguration::periodBlocks() const {
  return static_cast<std::uint64_t>(Identifier(identification, converter).periodBlocks());
}

}  // namespace cvg
