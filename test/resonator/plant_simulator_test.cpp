#include "ring_gyro/resonator/plant_simulator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>
#include <limits>

#include "resonator/reference_solution.h"
#include "ring_gyro/demodulation/demodulator.h"

namespace cvg {
namespace {

using Complex = std::complex<double>;
constexpr std::int64_t kStart = 1000000000;

PlantParameters paperPlant() {
  PlantParameters p;
  p.resonator.natural_frequency = 14000.0;
  p.resonator.quality_factor = 22000.0;
  p.resonator.gamma1 = 0.02;
  p.resonator.gamma2 = 0.03;
  p.resonator.mu1 = -30e-6;
  p.resonator.mu2 = -40e-6;
  p.resonator.drive_gain = 1.1e5;
  return p;
}

// Drives at the resonance for some blocks; NCO phase continuous.
class Bench {
 public:
  explicit Bench(const PlantParameters& parameters, std::uint64_t seed = 1)
      : parameters_(parameters),
        plant_(parameters, converter_, seed, 1, kStart),
        demodulator_({}, converter_, parameters.resonator.natural_frequency) {
    block_ = &plant_.start();
  }
  const DisplacementBlock& drive(const Eigen::Vector2cd& envelope) {
    DriveCommand command;
    command.answers_sequence = block_->stamp.sequence;
    command.reference_frequency = parameters_.resonator.angularFrequency();
    command.reference_phase = wrapToPi(block_->reference_phase +
                                       block_->reference_frequency * converter_.blockDuration());
    command.envelope = envelope;
    block_ = &plant_.step(command);
    envelope_ = demodulator_.process(*block_);
    return *block_;
  }
  // Envelope that the samples show after ringing up along both axes.
  Eigen::Vector2cd ringUp(const Eigen::Vector2cd& drive_envelope, int blocks = 200) {
    for (int n = 0; n < blocks; ++n) drive(drive_envelope);
    return envelope_;
  }
  PlantSimulator& plant() { return plant_; }
  const ConverterParameters& converter() const { return converter_; }

 private:
  PlantParameters parameters_;
  ConverterParameters converter_;
  PlantSimulator plant_;
  Demodulator demodulator_;
  const DisplacementBlock* block_;
  Eigen::Vector2cd envelope_;
};

const Eigen::Vector2cd kDrive{Complex(4.0, 0.0), Complex(0.0, 2.5)};

TEST(PlantSimulator, SameSeedSameSamplesOtherSeedOthers) {
  PlantParameters p = paperPlant();
  p.sense.noise_density = 5e-6;
  p.resonator.thermal_noise_density = 1e-6;
  Bench one(p, 3);
  Bench same(p, 3);
  Bench other(p, 4);
  for (int n = 0; n < 20; ++n) {
    const DisplacementBlock& a = one.drive(kDrive);
    EXPECT_EQ(a.x, same.drive(kDrive).x);
    EXPECT_NE(a.x, other.drive(kDrive).x);
  }
}

TEST(PlantSimulator, StampsAndEchoes) {
  Bench bench(paperPlant());
  EXPECT_FALSE(bench.plant().truth().stamp.sequence != 0);
  const DisplacementBlock& block = bench.drive(kDrive);
  EXPECT_EQ(block.stamp.sequence, 1u);
  EXPECT_EQ(block.stamp.end_ns, kStart + 2000000);
  EXPECT_TRUE(block.driven);
  EXPECT_EQ(block.drive_answers_sequence, 0u);
  const double phase = block.reference_phase;
  const double frequency = block.reference_frequency;
  const DisplacementBlock& coasted = bench.plant().coast();
  EXPECT_EQ(coasted.drive_answers_sequence, 0u);
  EXPECT_NEAR(wrapToPi(coasted.reference_phase - phase - 1e-3 * frequency), 0.0, 1e-9);
}

TEST(PlantSimulator, RefusesADriveThatIsNotFinite) {
  Bench bench(paperPlant());
  EXPECT_THROW(bench.drive({Complex(std::numeric_limits<double>::quiet_NaN(), 0.0), 0.0}),
               std::domain_error);
}

TEST(PlantSimulator, SenseGainsAndAxesAreSeen) {
  PlantParameters p = paperPlant();
  const Eigen::Vector2cd ideal = Bench(p).ringUp(kDrive);
  p.sense.axes.gain_x = 1.01;
  p.sense.axes.gain_y = 0.98;
  p.sense.axes.misalignment = 0.02;
  const Eigen::Vector2cd seen = Bench(p).ringUp(kDrive);
  const Eigen::Vector2cd expected = p.sense.axes.gainMatrix().cast<Complex>() * ideal;
  EXPECT_LT((seen - expected).norm(), 1e-12);
}

TEST(PlantSimulator, SensePhasesDelayTheEnvelopes) {
  PlantParameters p = paperPlant();
  const Eigen::Vector2cd ideal = Bench(p).ringUp(kDrive);
  p.sense.axes.phase_delay = 0.02;
  p.sense.axes.phase_difference = -0.005;
  const Eigen::Vector2cd seen = Bench(p).ringUp(kDrive);
  EXPECT_LT(std::abs(seen[0] - ideal[0] * std::polar(1.0, -0.02)), 1e-12);
  EXPECT_LT(std::abs(seen[1] - ideal[1] * std::polar(1.0, -0.015)), 1e-12);
}

TEST(PlantSimulator, DriveErrorsActOnTheForce) {
  PlantParameters p = paperPlant();
  p.drive.axes.gain_x = 1.02;
  p.drive.axes.phase_delay = 0.03;
  p.drive.axes.phase_difference = 0.01;
  p.drive.axes.misalignment = 0.01;
  const Eigen::Vector2cd seen = Bench(p).ringUp(kDrive);
  const Eigen::Vector2cd delayed(kDrive[0] * std::polar(1.0, -0.03),
                                 kDrive[1] * std::polar(1.0, -0.04));
  const Eigen::Vector2cd expected =
      Bench(paperPlant()).ringUp(p.drive.axes.gainMatrix().cast<Complex>() * delayed);
  EXPECT_LT((seen - expected).norm(), 1e-12);
}

TEST(PlantSimulator, CubicPickOffAddsThreeQuartersToTheFundamental) {
  PlantParameters p = paperPlant();
  const Eigen::Vector2cd ideal = Bench(p).ringUp({Complex(4.0, 0.0), 0.0});
  p.sense.cubic = 0.02;
  const Eigen::Vector2cd seen = Bench(p).ringUp({Complex(4.0, 0.0), 0.0});
  const double expected = std::abs(ideal[0]) * (1.0 + 0.75 * 0.02 * std::norm(ideal[0]));
  EXPECT_NEAR(std::abs(seen[0]), expected, 1e-7);
}

TEST(PlantSimulator, FeedthroughAddsTheDrive) {
  PlantParameters p = paperPlant();
  const Eigen::Vector2cd ideal = Bench(p).ringUp(kDrive);
  p.sense.feedthrough = 1e-3;
  const Eigen::Vector2cd seen = Bench(p).ringUp(kDrive);
  EXPECT_LT((seen - ideal - 1e-3 * kDrive).norm(), 1e-9);
}

TEST(PlantSimulator, SampleNoiseHasItsDensity) {
  PlantParameters p = paperPlant();
  p.sense.noise_density = 5e-6;
  Bench bench(p);
  double sum = 0.0;
  const int blocks = 500;
  for (int n = 0; n < blocks; ++n) {
    const DisplacementBlock& block = bench.drive(Eigen::Vector2cd::Zero());
    for (double sample : block.x) sum += sample * sample;
    for (double sample : block.y) sum += sample * sample;
  }
  const double variance = sum / (400.0 * blocks);
  EXPECT_NEAR(variance / (25e-12 * 100e3), 1.0, 0.012);  // 200,000 squares: 0.3 % sigma
}

// Fluctuation-dissipation: x settles at the variance S_a / (8 xi0 w0^3), S_a = (ks density)^2.
TEST(PlantSimulator, ThermalNoiseReachesEquipartition) {
  PlantParameters p = paperPlant();
  p.resonator.quality_factor = 1000.0;  // settles in 23 ms
  p.resonator.gamma1 = p.resonator.gamma2 = p.resonator.mu1 = p.resonator.mu2 = 0.0;
  p.resonator.thermal_noise_density = 1e-3;
  Bench bench(p, 5);
  double sum = 0.0;
  const int blocks = 60000;
  for (int n = 0; n < blocks; ++n) {
    bench.plant().coast();
    sum += bench.plant().truth().envelope.squaredNorm();
  }
  const double w0 = p.resonator.angularFrequency();
  const double force = p.resonator.drive_gain * p.resonator.thermal_noise_density;
  const double variance = force * force / (8.0 * p.resonator.dampingRatio() * w0 * w0 * w0);
  // Two axes, each envelope with twice the variance of its displacement; 2600 free samples.
  EXPECT_NEAR(sum / blocks / (4.0 * variance), 1.0, 0.06);
}

TEST(PlantSimulator, ConverterRoundsAndSaturates) {
  PlantParameters p = paperPlant();
  p.sense.adc_bits = 12;
  p.sense.adc_range = 0.4;
  Bench bench(p);
  const double level = 0.8 / 4096.0;
  std::uint32_t saturated = 0;
  for (int n = 0; n < 200; ++n) {
    const DisplacementBlock& block = bench.drive({Complex(10.0, 0.0), 0.0});
    saturated = block.saturated_samples;
    for (double sample : block.x) {
      ASSERT_NEAR(sample / level, std::nearbyint(sample / level), 1e-9);
      ASSERT_LE(std::abs(sample), 0.4);
    }
  }
  EXPECT_GT(saturated, 50u);
}

TEST(PlantSimulator, HeldDriveHasTheGainAndDelayOfAHold) {
  PlantParameters p = paperPlant();
  const Eigen::Vector2cd ideal = Bench(p).ringUp(kDrive);
  p.drive.zero_order_hold = true;
  const Eigen::Vector2cd seen = Bench(p).ringUp(kDrive);
  const double half = 0.5 * p.resonator.angularFrequency() / 200e3;
  const Complex hold = std::polar(std::sin(half) / half, -half);
  EXPECT_NEAR(std::abs(hold), 0.992, 0.001);
  EXPECT_LT((seen - hold * ideal).norm(), 2e-5);
}

TEST(PlantSimulator, DacBitsNeedAHeldDrive) {
  PlantParameters p = paperPlant();
  p.drive.dac_bits = 16;
  EXPECT_THROW(PlantSimulator(p, {}, 1, 1, kStart), std::invalid_argument);
  p.drive.zero_order_hold = true;
  p.drive.dac_range = 5.0;
  EXPECT_LT((Bench(p).ringUp(kDrive) -
             [&] {
               PlantParameters fine = p;
               fine.drive.dac_bits = 0;
               return Bench(fine).ringUp(kDrive);
             }())
                .norm(),
            1e-4);
}

// The samples of a plant from rest against the solver, which is given the volts of each moment.
double squareLawError(bool held) {
  PlantParameters p = paperPlant();
  p.drive.bias_voltage = 25.0;
  p.drive.zero_order_hold = held;
  const ConverterParameters converter;
  PlantSimulator plant(p, converter, 1, 1, kStart);
  const ReferenceSolution solver(p.resonator);
  ReferenceSolution::State reference = {};
  plant.start();
  using Real = ReferenceSolution::Real;
  const Real h = 5e-6;
  DriveCommand command;
  command.reference_frequency = p.resonator.angularFrequency() + 4.0;
  double largest = 0.0;
  for (int block = 0; block < 50; ++block) {
    command.reference_phase = 0.3 * block;
    command.envelope = {Complex(4.0, 0.1 * block), Complex(-0.2 * block, 2.5)};
    const DisplacementBlock& samples = plant.step(command);
    for (int j = 0; j < 200; ++j) {
      const auto index = static_cast<std::size_t>(j);
      largest = std::max({largest, std::abs(samples.x[index] - static_cast<double>(reference[0])),
                          std::abs(samples.y[index] - static_cast<double>(reference[1]))});
      const auto force = [&](int axis, Real t) {
        const Real turn =
            command.reference_phase + Real(command.reference_frequency) * (held ? h * j : t);
        const Real volts = Real(command.envelope[axis].real()) * std::cos(turn) -
                           Real(command.envelope[axis].imag()) * std::sin(turn);
        return volts + volts * volts / 50.0L;
      };
      solver.integrate(
          reference, h * j, h * (j + 1), [&](Real t) { return force(0, t); },
          [&](Real t) { return force(1, t); }, [](Real) { return 0.0L; });
    }
  }
  return largest;
}

TEST(PlantSimulator, SquareLawOfTheDriveIsExactOnBothPaths) {
  for (const bool held : {false, true}) {
    const double error = squareLawError(held);
    std::printf(
        "[figure] square law at 25 V bias, %s drive, against ODE, 50 ms: %.2e V "
        "(must 1e-11)\n",
        held ? "held" : "ideal", error);
    EXPECT_LT(error, 1e-11);
  }
}

TEST(PlantSimulator, SquareLawMovesTheRestPosition) {
  PlantParameters p = paperPlant();
  const double w2 = std::pow(p.resonator.angularFrequency(), 2);
  const auto meanOf = [](const PlantParameters& plant) {
    Bench bench(plant);
    bench.ringUp(kDrive, 10);
    double sum = 0.0;  // over 14 cycles, a whole block at 14 kHz
    for (const double sample : bench.drive(kDrive).x) sum += sample;
    return sum / 200.0;
  };
  const double before = meanOf(p);
  p.drive.bias_voltage = 25.0;
  const double expected = p.resonator.drive_gain * 16.0 / (4.0 * 25.0) / w2;
  EXPECT_NEAR((meanOf(p) - before) / expected, 1.0, 2e-3);
}

TEST(PlantSimulator, DriveAndResonatorHaveOneBias) {
  PlantParameters p = paperPlant();
  p.resonator.bias_voltage = 20.0;
  p.drive.bias_voltage = 25.0;
  EXPECT_THROW(PlantSimulator(p, {}, 1, 1, kStart), std::invalid_argument);
}

TEST(PlantSimulator, RateOfTheTableAtCommandIsARateOfTheProfile) {
  PlantParameters p = paperPlant();
  Bench commanded(p);
  p.rotation.rate = 0.5;
  Bench profile(p);
  profile.ringUp(kDrive, 20);
  commanded.plant().setRotationRate(0.0);
  commanded.ringUp(kDrive, 10);
  EXPECT_EQ(commanded.plant().truth().rotation_rate, 0.0);
  commanded.plant().setRotationRate(0.5);
  EXPECT_EQ(commanded.plant().truth().rotation_rate, 0.0) << "acts from the next block on";
  commanded.ringUp(kDrive, 10);
  EXPECT_EQ(commanded.plant().truth().rotation_rate, 0.5);
  EXPECT_NEAR(commanded.plant().truth().rotation_angle, 0.5 * 10e-3, 1e-15);
  // Block 0 and ten more at rest, ten that turn; the other turned all along.
  PlantParameters still = paperPlant();
  still.rotation.profile = RotationShape::kStep;
  still.rotation.rate = 0.5;
  still.rotation.step_time = 11e-3;
  Bench step(still);
  step.ringUp(kDrive, 20);
  const Eigen::Vector2cd truth = commanded.plant().truth().envelope;
  EXPECT_LT((truth - step.plant().truth().envelope).norm(), 1e-15);
  EXPECT_GT((truth - profile.plant().truth().envelope).norm(), 1e-6);
  EXPECT_THROW(commanded.plant().setRotationRate(std::numeric_limits<double>::infinity()),
               std::domain_error);
}

TEST(PlantSimulator, ExactAndSampledPathsAgree) {
  PlantParameters p = paperPlant();
  p.rotation.rate = 0.5;
  Bench exact(p);
  p.rotation.profile = RotationShape::kSine;  // the same mean, a swing too small to matter
  p.rotation.amplitude = 1e-13;
  p.rotation.frequency = 1.0;
  Bench sampled(p);
  for (int n = 0; n < 300; ++n) {
    const AlignedVector x = exact.drive(kDrive).x;
    const DisplacementBlock& other = sampled.drive(kDrive);
    for (std::size_t j = 0; j < x.size(); j += 37) ASSERT_NEAR(x[j], other.x[j], 1e-11);
  }
}

TEST(PlantSimulator, TruthIsTheMotionOfTheSamples) {
  Bench bench(paperPlant());
  const Eigen::Vector2cd seen = bench.ringUp(kDrive);
  const Eigen::Vector2cd truth = bench.plant().truth().envelope;
  EXPECT_LT((seen - truth).norm(), 1e-2 * truth.norm());  // 0.63 ms apart, still growing
  EXPECT_GT((seen - truth).norm(), 1e-4 * truth.norm());
}

TEST(PlantSimulator, TemperatureMovesFrequencyQAndGamma) {
  PlantParameters p = paperPlant();
  p.resonator.temperature_rate = 2.0;
  p.resonator.frequency_temperature_coefficient = -20e-6;
  p.resonator.quality_temperature_coefficient = -1e-3;
  p.resonator.gamma_temperature_coefficient = 5e-3;
  Bench bench(p);
  for (int n = 0; n < 999; ++n) bench.drive(kDrive);
  EXPECT_NEAR(bench.plant().truth().natural_frequency, 14000.0 * (1.0 - 40e-6), 1e-9);
  EXPECT_NEAR(bench.plant().truth().quality_factor, 22000.0 * (1.0 - 2e-3), 1e-6);
  EXPECT_NEAR(bench.plant().truth().gamma1, 0.02 * 1.01, 1e-12);
  EXPECT_NEAR(bench.plant().truth().gamma2, 0.03 * 1.01, 1e-12);
}

// Decay along an axis goes with 1 + gamma1: a ring whose gamma changed is one that always had it.
TEST(PlantSimulator, GammaOfTheTemperatureActs) {
  PlantParameters warm = paperPlant();
  warm.resonator.temperature_rate = 1.0;
  Bench unmoved(warm);
  warm.resonator.gamma_temperature_coefficient = 0.01;  // from 0.02 to 0.02 (1 + 0.01 t)
  Bench moved(warm);
  unmoved.ringUp({4.0, 0.0});
  moved.ringUp({4.0, 0.0});
  const double before = std::abs(unmoved.plant().truth().envelope[0]);
  const double after = std::abs(moved.plant().truth().envelope[0]);
  EXPECT_LT(after, before - 1e-8);
  EXPECT_NEAR(after / before, 1.0, 1e-4);
}

TEST(ResonatorParameters, DriveGainFromTheCapacitors) {
  ResonatorParameters p;
  p.bias_voltage = 25.0;
  p.electrode_gap = 6e-6;
  p.electrode_capacitance = 0.3e-12;
  p.feedback_capacitance = 1e-12;
  p.modal_mass = 1e-8;
  const double eta = 25.0 * 0.3e-12 / 6e-6;
  EXPECT_NEAR(p.driveGain(), eta * eta / (1e-8 * 1e-12), 1e-6);
  p.drive_gain = 1.0;
  EXPECT_THROW(p.driveGain(), std::invalid_argument);
  p.drive_gain = 0.0;
  p.modal_mass = 0.0;
  EXPECT_THROW(p.driveGain(), std::invalid_argument);
}

// The stiffness matrix itself: w0^2 M less the softening along each electrode.
TEST(ResonatorParameters, TuningVoltagesSoftenAlongTheirElectrodes) {
  ResonatorParameters p = paperPlant().resonator;
  p.tuning_gain = 2e-7;
  p.tuning_voltage_0 = 12.0;
  p.tuning_voltage_90 = 3.0;
  p.tuning_voltage_45 = 5.0;
  p.tuning_voltage_135 = -14.0;
  const double w2 = p.angularFrequency() * p.angularFrequency();
  Eigen::Matrix2d expected;
  expected << 1.0 + p.mu1, p.mu2, p.mu2, 1.0 - p.mu1;
  const double angles[] = {0.0, 0.5 * kPi, 0.25 * kPi, 0.75 * kPi};
  const double volts[] = {12.0, 3.0, 5.0, -14.0};
  for (int k = 0; k < 4; ++k) {
    const Eigen::Vector2d along(std::cos(angles[k]), std::sin(angles[k]));
    expected -= p.tuning_gain * volts[k] * volts[k] * along * along.transpose();
  }
  const ResonatorParameters tuned = p.tuned();
  Eigen::Matrix2d found;
  found << 1.0 + tuned.mu1, tuned.mu2, tuned.mu2, 1.0 - tuned.mu1;
  found *= tuned.angularFrequency() * tuned.angularFrequency() / w2;
  EXPECT_LT((found - expected).norm(), 1e-15);
  EXPECT_NEAR(tuned.decayRate(), p.decayRate(), 1e-12) << "tuning does not change the damping";
  p.tuning_gain = 1e-2;
  EXPECT_THROW(p.tuned(), std::invalid_argument);
}

}  // namespace
}  // namespace cvg
