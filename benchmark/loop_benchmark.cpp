// The plant and the closed loop in one process against the usual ways to write them.

#include "loop_benchmark.h"

#include <sched.h>

#include <algorithm>
#include <array>
#include <boost/numeric/odeint.hpp>
#include <cerrno>
#include <cmath>
#include <stdexcept>
#include <system_error>
#include <vector>

#include "interleaved.h"
#include "plain_loop.h"
#include "resonator/reference_solution.h"
#include "ring_gyro/common/item_range.h"
#include "ring_gyro/configuration/configuration_reader.h"
#include "ring_gyro/simulation/closed_loop.h"
#include "ring_gyro/simulation/monte_carlo.h"

namespace cvg {
namespace {

namespace odeint = boost::numeric::odeint;

constexpr double kSettled = 10.0;  // from here on everything is locked and identified [s]
// Long enough that the cost of changing the work, such as waking the wide vector units, is
// negligible.
constexpr int kBlocksATurn = 1000;

PlantParameters changingPlant() {
  PlantParameters plant;
  ResonatorParameters& ring = plant.resonator;
  ring.natural_frequency = 14e3;
  ring.quality_factor = 22000.0;
  ring.gamma1 = 0.02;
  ring.gamma2 = 0.03;
  ring.mu1 = -30e-6;
  ring.mu2 = -40e-6;
  ring.drive_gain = 1.1e5;
  // Conditions that differ in every block, so that nothing can be reused.
  ring.temperature_rate = 1.0;
  ring.frequency_temperature_coefficient = -25e-6;
  ring.quality_temperature_coefficient = 1e-3;
  plant.rotation.rate = 0.2;
  return plant;
}

DriveCommand drive(std::uint64_t answers, double phase) {
  const double n = static_cast<double>(answers);
  DriveCommand command;
  command.answers_sequence = answers;
  command.reference_phase = phase;
  command.reference_frequency = kTwoPi * (14e3 + std::sin(0.01 * n));
  command.envelope << std::complex<double>(std::cos(0.03 * n), std::sin(0.02 * n)),
      std::complex<double>(0.3 * std::sin(0.05 * n), 0.1);
  return command;
}

/// The same plant and drives for an integrator of the state (x, y, x', y').
template <typename Real>
class OdePlant {
 public:
  using State = std::array<Real, 4>;

  explicit OdePlant(const PlantParameters& plant) : plant_(plant) {}

  void setBlock(const DriveCommand& command, double begin) {
    command_ = command;
    const ResonatorParameters& p = plant_.resonator;
    const Real temperature = Real(p.temperature_rate) * begin;
    w0_ = Real(kTwoPi) * p.natural_frequency *
          (1 + Real(p.frequency_temperature_coefficient) * temperature);
    damping_ =
        w0_ / (p.quality_factor * (1 + Real(p.quality_temperature_coefficient) * temperature));
  }
  void operator()(const State& s, State& rate, Real t) const {
    const ResonatorParameters& p = plant_.resonator;
    const Real phase = command_.reference_phase + Real(command_.reference_frequency) * t;
    const Real c = std::cos(phase), q = std::sin(phase);
    const Real fx = command_.envelope.x().real() * c - command_.envelope.x().imag() * q;
    const Real fy = command_.envelope.y().real() * c - command_.envelope.y().imag() * q;
    const Real coriolis = 2 * Real(p.angular_gain) * Real(plant_.rotation.rate);
    rate[0] = s[2];
    rate[1] = s[3];
    rate[2] = p.drive_gain * fx + coriolis * s[3] -
              damping_ * ((1 + p.gamma1) * s[2] + p.gamma2 * s[3]) -
              w0_ * w0_ * ((1 + p.mu1) * s[0] + p.mu2 * s[1]);
    rate[3] = p.drive_gain * fy - coriolis * s[2] -
              damping_ * (p.gamma2 * s[2] + (1 - p.gamma1) * s[3]) -
              w0_ * w0_ * (p.mu2 * s[0] + (1 - p.mu1) * s[1]);
  }

  State state{};

 private:
  PlantParameters plant_;
  DriveCommand command_;
  Real w0_ = 0;
  Real damping_ = 0;
};

/// The Fehlberg 7(8) method with a fixed step.
template <typename Real>
class OdeRun {
 public:
  explicit OdeRun(const PlantParameters& plant) : plant_(plant) {}

  /// Samples of x over one block.
  void block(const DriveCommand& command, double begin, int steps, std::vector<double>& samples) {
    plant_.setBlock(command, begin);
    const Real h = Real(5e-6) / steps;
    for (std::size_t j = 0; j < samples.size(); ++j) {
      samples[j] = static_cast<double>(plant_.state[0]);
      for (int k = 0; k < steps; ++k) {
        stepper_.do_step(plant_, plant_.state, Real(5e-6) * static_cast<Real>(j) + h * k, h);
      }
    }
  }

 private:
  OdePlant<Real> plant_;
  odeint::runge_kutta_fehlberg78<std::array<Real, 4>, Real> stepper_;
};

LoopConfiguration configurationOf(const std::string& file, double period, bool compensation) {
  return readConfigurationFile(
      file, {"identification/update_period=" + std::to_string(period),
             std::string("control/compensation=") + (compensation ? "true" : "false")});
}

/// Plant and loops, nothing else.
class LoopAlone {
 public:
  explicit LoopAlone(const LoopConfiguration& configuration)
      : plant_(configuration.plant, configuration.converter, 1, 1,
               configuration.run.startNanoseconds()),
        loops_(configuration.device, configuration.control, configuration.demodulation,
               configuration.converter),
        output_(&loops_.process(plant_.start())) {}

  void step() { output_ = &loops_.process(plant_.step(output_->command)); }
  bool locked() const { return output_->elements.status.locked(); }

 private:
  PlantSimulator plant_;
  ControlLoops loops_;
  const LoopOutput* output_;
};

/// Processor cores on which the calling thread and the threads it starts may run. The destructor
/// restores them.
class Cores {
 public:
  /// Throws std::system_error if the system does not tell the cores.
  Cores() {
    if (sched_getaffinity(0, sizeof before_, &before_) != 0) fail("asking for the cores");
    for (int core = 0; core < CPU_SETSIZE; ++core) {
      if (CPU_ISSET(core, &before_)) numbers_.push_back(core);
    }
  }
  ~Cores() { sched_setaffinity(0, sizeof before_, &before_); }
  Cores(const Cores&) = delete;
  Cores& operator=(const Cores&) = delete;

  /// All cores that may be used.
  const std::vector<int>& numbers() const { return numbers_; }
  /// From now on runs on these cores only; throws std::system_error if this is not allowed.
  void keepTo(const std::vector<int>& numbers) {
    cpu_set_t set;
    CPU_ZERO(&set);
    for (const int core : numbers) CPU_SET(core, &set);
    if (sched_setaffinity(0, sizeof set, &set) != 0) fail("keeping to a core");
  }

 private:
  static void fail(const char* what) {
    throw std::system_error(errno, std::generic_category(), what);
  }

  cpu_set_t before_;
  std::vector<int> numbers_;
};

template <typename Loop>
void run(Loop& loop, double duration) {
  for (int n = 0; n < std::lround(1e3 * duration); ++n) loop.step();
}

}  // namespace

void plantAgainstOdeint(benchmark::State& state) {
  const PlantParameters plant = changingPlant();
  constexpr std::int64_t kStart = 1000000000;
  const auto begin = [](std::uint64_t sequence) { return 1e-3 * static_cast<double>(sequence); };
  const auto next = [](const DriveCommand& command) {
    return drive(
        command.answers_sequence + 1,
        std::remainder(command.reference_phase + command.reference_frequency * 1e-3, kTwoPi));
  };

  // Accuracy over the first second.
  double our_error = 0.0, peer_error = 0.0, amplitude = 0.0;
  {
    PlantSimulator ours(plant, {}, 1, 1, kStart);
    ours.start();
    OdeRun<double> peer(plant);
    OdeRun<long double> reference(plant);
    std::vector<double> peer_x(200), reference_x(200);
    DriveCommand command = drive(0, 0.0);
    for (std::uint64_t n = 1; n <= 1000; ++n) {
      const DisplacementBlock& block = ours.step(command);
      peer.block(command, begin(n), 1, peer_x);
      reference.block(command, begin(n), 4, reference_x);
      for (std::size_t j = 0; j < 200; ++j) {
        amplitude = std::max(amplitude, std::abs(reference_x[j]));
        our_error = std::max(our_error, std::abs(block.x[j] - reference_x[j]));
        peer_error = std::max(peer_error, std::abs(peer_x[j] - reference_x[j]));
      }
      command = next(command);
    }
  }

  PlantSimulator ours(plant, {}, 1, 1, kStart);
  ours.start();
  OdeRun<double> peer(plant);
  std::vector<double> samples(200);
  DriveCommand our_command = drive(0, 0.0);
  DriveCommand peer_command = our_command;
  constexpr int kOurBlocks = 200;
  constexpr int kPeerBlocks = 5;
  std::uint64_t block = 1;
  timeInTurns(
      state, threadTime, kOurBlocks,
      [&] {
        for (int n = 0; n < kOurBlocks; ++n) {
          benchmark::DoNotOptimize(ours.step(our_command).x.data());
          our_command = next(our_command);
        }
      },
      kPeerBlocks,
      [&] {
        for (int n = 0; n < kPeerBlocks; ++n) {
          peer.block(peer_command, begin(block++), 1, samples);
          peer_command = next(peer_command);
        }
      });
  state.counters["our_error"] = our_error / amplitude;
  state.counters["peer_error"] = peer_error / amplitude;
}

void loopAgainstPlain(benchmark::State& state, const std::string& configuration_file) {
  const LoopConfiguration configuration = configurationOf(configuration_file, 0.1, false);
  LoopAlone ours(configuration);
  PlainLoop peer(configuration);
  run(ours, kSettled);
  Orbit orbit;
  for (int n = 0; n < 300; ++n) orbit = peer.step();
  if (!ours.locked() || std::abs(orbit.a - 1.0) > 0.02 || std::abs(orbit.phi + kPi / 2) > 0.02) {
    throw std::runtime_error("a loop has not locked");
  }
  constexpr int kPeerBlocks = 20;
  timeInTurns(
      state, threadTime, kBlocksATurn, [&] { run(ours, 1e-3 * kBlocksATurn); }, kPeerBlocks,
      [&] {
        for (int n = 0; n < kPeerBlocks; ++n) benchmark::DoNotOptimize(peer.step());
      });
  state.counters["speed"] = configuration.converter.blockDuration() / state.counters["ours"];
}

void chainAgainstLoop(benchmark::State& state, const std::string& configuration_file,
                      double period) {
  const LoopConfiguration configuration = configurationOf(configuration_file, period, true);
  ClosedLoop ours(configuration);
  LoopAlone peer(configuration);
  run(ours, kSettled);
  run(peer, kSettled);
  timeInTurns(
      state, threadTime, kBlocksATurn, [&] { run(ours, 1e-3 * kBlocksATurn); }, kBlocksATurn,
      [&] { run(peer, 1e-3 * kBlocksATurn); });
}

void oldAgainstYoung(benchmark::State& state, const std::string& configuration_file, double age) {
  const LoopConfiguration configuration = configurationOf(configuration_file, 0.1, true);
  ClosedLoop old(configuration);
  ClosedLoop young(configuration);
  run(old, age);
  run(young, 1.0);
  timeInTurns(
      state, threadTime, kBlocksATurn, [&] { run(old, 1e-3 * kBlocksATurn); }, kBlocksATurn,
      [&] { run(young, 1e-3 * kBlocksATurn); });
}

/// On a rented machine one core can be 1.5 times as fast as the other for minutes. So the work of
/// the single thread is done half on one core and half on the other, by pinning the calling thread.
void twoCoresAgainstOne(benchmark::State& state, const std::string& configuration_file) {
  constexpr std::uint64_t kItems = 128;
  MonteCarlo batch;
  batch.configuration = configurationOf(configuration_file, 0.1, true);
  batch.configuration.run.duration = 2.0;
  ItemRange range;
  range.count = kItems;
  const auto run = [&](unsigned threads, std::uint64_t count) {
    range.count = count;
    runMonteCarlo(batch, range.indices(), threads, [](const MonteCarloItem& item) {
      if (!item.refused.empty()) throw std::runtime_error(item.refused);
    });
  };
  Cores cores;
  if (cores.numbers().size() < 2) throw std::runtime_error("Monte Carlo on 2 cores needs 2 cores");
  const std::vector<int> both(cores.numbers().begin(), cores.numbers().begin() + 2);
  timeInTurns(
      state, wallTime, kItems,
      [&] {
        cores.keepTo(both);
        run(2, kItems);
      },
      kItems,
      [&] {
        for (const int core : both) {
          cores.keepTo({core});
          run(1, kItems / 2);
        }
      });
}

}  // namespace cvg
