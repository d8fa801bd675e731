// Harmonics of the drift and of the angle scale, sense matrix and scale of the rotation. The
// time-domain plant cannot have these errors one by one, so the envelope model simulates them, and
// the identifier must find them.

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <random>

#include "ring_gyro/common/angle.h"
#include "ring_gyro/control/drive_synthesis.h"
#include "ring_gyro/demodulation/orbit.h"
#include "ring_gyro/identification/filter/extended_identifier.h"
#include "ring_gyro/identification/model/averaged_model.h"

namespace cvg {
namespace {

constexpr double kFrequency = 14e3;  // [Hz]
constexpr double kNoise = 5e-6;      // [V/sqrt(Hz)]
constexpr double kBlock = 1e-3;      // [s]

/// A locked loop around the envelope model; its electronics delay nothing.
class ModelLoop {
 public:
  struct Output {
    OrbitalElements elements;
    ControlGains gains;
  };

  /// `truth` in physical coordinates.
  ModelLoop(const ExtendedState& state, const ExtendedVector& truth, unsigned seed)
      : model_(state), linear_(state.linear(truth)), engine_(seed), noise_(0.0, 1.0) {
    envelope_ = realParts(envelopeFromOrbit({1.0, 0.0, 0.1, -kPi / 2}));
    measure();
    amplitude_integral_ = state.decayRate(linear_);
    command();
  }

  Output step(double virtual_rate, double rotation_rate) {
    virtual_rate_ = virtual_rate;
    const Eigen::Vector2cd drive = next_.drive.total();
    EnvelopeInput input;
    input.drive = drive + driveStep(last_drive_, drive, next_.reference_phase,
                                    next_.reference_frequency, kBlock);
    input.reference_frequency = next_.reference_frequency;
    input.rotation_rate = rotation_rate;
    input.theta = theta_ + 0.5 * kBlock * theta_rate_;
    EnvelopeStep step;
    model_.step(envelope_, linear_, {envelope_, linear_}, input, kBlock, step);
    envelope_ = step.after;
    last_drive_ = drive;

    Output output;
    output.gains = next_;
    output.gains.stamp = {1, sequence_, 1000000000 + std::int64_t(1000000 * (sequence_ + 1)),
                          1000000};
    ++sequence_;
    measure();
    output.elements.stamp = output.gains.stamp;
    output.elements.orbit = measured_;
    LoopStatus& status = output.elements.status;
    status.amplitude_locked = status.quadrature_locked = status.phase_locked = true;
    output.gains.status = status;
    command();
    return output;
  }

 private:
  static Eigen::Vector2cd complexOf(const Eigen::Vector4d& parts) {
    return {std::complex<double>(parts[0], parts[1]), std::complex<double>(parts[2], parts[3])};
  }

  void measure() {
    const double before = theta_;
    theta_ += wrapToPi(orbitFromEnvelope(complexOf(envelope_)).theta - theta_);
    theta_rate_ = sequence_ > 0 ? (theta_ - before) / kBlock : 0.0;
    Eigen::Vector4d shown = model_.measure(envelope_, linear_).value;
    for (int k = 0; k < 4; ++k) shown[k] += kNoise / std::sqrt(kBlock) * noise_(engine_);
    const double unwrapped = measured_.theta;
    measured_ = orbitFromEnvelope(complexOf(shown));
    measured_.theta = unwrapped + wrapToPi(measured_.theta - unwrapped);
  }

  void command() {
    const double wn = kTwoPi * 10.0;
    const auto loop = [&](double error, double& integral) {
      integral += wn * wn * error * kBlock;
      return 2.0 * wn * error + integral;
    };
    const double ks = std::abs(model_.state().driveGain(linear_));
    const double w = kTwoPi * kFrequency + loop(measured_.phi + kPi / 2, phase_integral_);
    const double force_per_rate = 2.0 * w / ks;
    DriveGains gains;
    gains.sustain_force = force_per_rate * loop(1.0 - measured_.a, amplitude_integral_);
    gains.alpha = force_per_rate * loop(measured_.b, quadrature_integral_);
    gains.virtual_rate = virtual_rate_;
    next_ = ControlGains{};
    next_.reference_phase = wrapToPi(phase_);
    phase_ += w * kBlock;
    next_.reference_frequency = w;
    next_.drive = synthesizeDrive(measured_, gains, w, ks);
  }

  EnvelopeModel model_;
  ExtendedVector linear_;
  std::mt19937 engine_;
  std::normal_distribution<double> noise_;
  Eigen::Vector4d envelope_;
  double theta_ = 0.1;
  double theta_rate_ = 0.0;
  Orbit measured_{1.0, 0.0, 0.1, -kPi / 2};
  double virtual_rate_ = 0.0;
  double amplitude_integral_ = 0.0;
  double quadrature_integral_ = 0.0;
  double phase_integral_ = 0.0;
  double phase_ = 0.0;
  ControlGains next_;
  Eigen::Vector2cd last_drive_ = Eigen::Vector2cd::Zero();
  std::uint64_t sequence_ = 0;
};

ExtendedVector truthFor(const ExtendedState& state) {
  const ExtendedState::Layout& at = state.layout();
  ExtendedVector truth = ExtendedVector::Zero(state.size());
  truth.segment<5>(at.gamma) << 0.02, -0.03, 5e-7, -4e-7, 1.1e5;
  truth[at.decay_rate] = kPi * kFrequency / 22000.0;
  truth[at.frequency] = kFrequency + 0.1;
  for (Eigen::Index k = at.frequency + 1; k < state.size(); ++k) {
    truth[k] = 1e-3 * std::sin(2.0 * static_cast<double>(k));
  }
  return truth;
}

void expectEverythingFound(ExtendedParameters parameters) {
  const DeviceKnowledge known = {kFrequency, 20000.0};
  parameters.noise_density = kNoise;
  parameters.envelope_process_noise = 0.0;
  const ExtendedState state(known, parameters);
  const ExtendedVector truth = truthFor(state);
  ExtendedIdentifier identifier(known, parameters, ConverterParameters());
  ModelLoop loop(state, truth, 1);
  ExtendedEstimate last;
  double nis = 0.0;
  int updates = 0;
  for (int n = 0; n < 120000; ++n) {
    // Steered in both directions, then turned in both directions.
    const double rate = n % 40000 < 20000 ? 0.3 : -0.3;
    const double steering = n < 60000 ? rate : 0.0;
    const double rotation = n < 60000 ? 0.0 : rate;
    const ModelLoop::Output output = loop.step(steering, rotation);
    const auto estimate = identifier.process(output.elements, output.gains, rotation);
    if (!estimate) continue;
    last = *estimate;
    if (!last.settled || !last.updated || !last.whole_period) continue;
    nis += last.normalised_innovation_squared;
    ++updates;
  }
  ASSERT_TRUE(last.settled);
  EXPECT_NEAR(nis / updates, 4.0, 4.0 * std::sqrt(8.0 / updates));
  for (Eigen::Index k = 4; k < state.size(); ++k) {
    const std::string& name = state.names()[static_cast<std::size_t>(k)];
    EXPECT_NEAR(last.value[k], truth[k], 4.5 * last.sigma(k)) << name;
    const bool of_electronics = k > state.layout().frequency;
    EXPECT_LT(last.sigma(k), of_electronics ? 1e-4 : 10.0) << name;
  }
}

TEST(ExtendedHarmonics, EvenAndOddHarmonicsSeparateByTheSignOfTheRotation) {
  ExtendedParameters parameters;
  parameters.even_harmonics = {1.0, 2.0, 3.0, 4.0};
  parameters.odd_harmonics = {1.0, 2.0, 3.0, 4.0};
  parameters.drift_bias = true;
  expectEverythingFound(parameters);
}

TEST(ExtendedHarmonics, EveryGroupAtOnce) {
  ExtendedParameters parameters;
  parameters.drive_matrix = parameters.drive_rotation = parameters.drift_bias = true;
  parameters.sense_matrix = parameters.rotation_scale = parameters.pickoff_cubic = true;
  parameters.even_harmonics = {1.0, 2.0, 3.0, 4.0};
  parameters.odd_harmonics = {1.0, 3.0, 4.0};
  expectEverythingFound(parameters);
}

}  // namespace
}  // namespace cvg
