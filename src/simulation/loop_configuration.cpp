#include "ring_gyro/simulation/loop_configuration.h"

#include <chrono>
#include <cmath>

namespace cvg {
namespace {

// A parameter server has 32-bit integers, and message stamps have unsigned 32-bit seconds.
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
      .integer("seed", seed, Range::between(0.0, kLargestInteger), "seed of all noise")
      .integer("session", session, Range::between(0.0, kLargestInteger),
               "number of this start of the plant; a plant node that is started again uses the "
               "next number; 0: from the wall clock, so that the messages of each run differ")
      .number("start_time", start_time, "s", Range::between(1e-9, 2e9),
              "stamp of the start of the first block; not zero, because zero means no time in ROS");
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

std::uint64_t LoopConfiguration::periodBlocks() const {
  return static_cast<std::uint64_t>(identification.periodBlocks(converter));
}

}  // namespace cvg
