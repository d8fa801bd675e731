// The identifier with the time-domain plant and the real loops: these errors contain everything
// that the averaged model leaves out.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "ring_gyro/common/angle.h"
#include "ring_gyro/control/control_loops.h"
#include "ring_gyro/identification/filter/identifier.h"
#include "ring_gyro/resonator/plant_simulator.h"

namespace cvg {
namespace {

struct Case {
  const char* name;
  double frequency = 14e3;
  double gamma1 = 0.02;
  double gamma2 = 0.03;
  double noise_density = 0.0;
  double virtual_rate = 0.20944;
  double rotation_rate = 0.0;
  double attenuation = 120.0;  // of the demodulator [dB]: sets its length
  double sample_rate = 200e3;
  std::int64_t block_samples = 200;
};

struct Errors {
  double gamma;
  double mu;
  double drive_gain;  // relative
};

Errors identify(const Case& conditions) {
  ConverterParameters converter;
  converter.sample_rate = conditions.sample_rate;
  converter.block_samples = conditions.block_samples;
  PlantParameters plant_parameters;
  ResonatorParameters& ring = plant_parameters.resonator;
  ring.natural_frequency = conditions.frequency;
  ring.quality_factor = 22000.0;
  ring.gamma1 = conditions.gamma1;
  ring.gamma2 = conditions.gamma2;
  ring.mu1 = -30e-6;
  ring.mu2 = -40e-6;
  ring.drive_gain = 1.1e5;
  plant_parameters.sense.noise_density = conditions.noise_density;
  plant_parameters.rotation.rate = conditions.rotation_rate;
  const DeviceKnowledge known = {conditions.frequency, 22000.0, 1.0e5};  // a wrong ks
  ControlParameters control;
  control.virtual_rate = conditions.virtual_rate;
  DemodulationParameters demodulation;
  demodulation.stopband_attenuation = conditions.attenuation;

  PlantSimulator plant(plant_parameters, converter, 1, 1, 1000000000);
  ControlLoops loops(known, control, demodulation, converter);
  Identifier identifier(known, IdentificationParameters(), converter);
  ParameterEstimate last;
  const DisplacementBlock* block = &plant.start();
  const auto blocks = std::llround(60.0 / converter.blockDuration());
  for (long long n = 0; n < blocks; ++n) {
    const LoopOutput& output = loops.process(*block);
    const auto estimate = identifier.process(output.elements, output.gains);
    if (estimate) last = *estimate;
    block = &plant.step(output.command);
  }
  EXPECT_TRUE(last.converged);
  const Errors errors{
      std::hypot(last.value[kGamma1] - ring.gamma1, last.value[kGamma2] - ring.gamma2),
      std::hypot(last.value[kMu1] - ring.mu1, last.value[kMu2] - ring.mu2),
      std::abs(last.value[kDriveGain] / ring.drive_gain - 1.0)};
  std::printf("%s, delay %.4f ms: gamma %.1e, mu %.1e, ks %.1e after 60 s\n", conditions.name,
              1e3 * loops.groupDelay(), errors.gamma, errors.mu, errors.drive_gain);
  return errors;
}

void expectBelow(const Errors& errors, double gamma, double mu, double drive_gain) {
  EXPECT_LT(errors.gamma, gamma);
  EXPECT_LT(errors.mu, mu);
  EXPECT_LT(errors.drive_gain, drive_gain);
}

TEST(IdentifierOnPlant, WithoutNoise) {
  Case conditions{"14 kHz, noise off"};
  expectBelow(identify(conditions), 1e-8, 1e-11, 3e-8);
}

TEST(IdentifierOnPlant, WithNoise) {
  Case conditions{"14 kHz, 5 uV/sqrt(Hz)"};
  conditions.noise_density = 5e-6;
  expectBelow(identify(conditions), 5e-6, 3e-10, 5e-6);
}

TEST(IdentifierOnPlant, OtherDevice) {
  Case conditions{"14.195 kHz"};
  conditions.frequency = 14195.0;
  conditions.gamma1 = 0.035;
  conditions.gamma2 = -0.006;
  expectBelow(identify(conditions), 1e-8, 1e-11, 3e-8);
}

TEST(IdentifierOnPlant, TrueRotationIsNotKnownAndDoesNotMatter) {
  Case conditions{"rotated by hand"};
  conditions.virtual_rate = 0.0;
  conditions.rotation_rate = 0.5;
  expectBelow(identify(conditions), 1e-8, 1e-11, 3e-8);
}

TEST(IdentifierOnPlant, AnyGroupDelay) {
  Case longer{"longer filter"};
  longer.attenuation = 160.0;
  expectBelow(identify(longer), 1e-8, 1e-11, 3e-8);
  Case shorter_blocks{"half a millisecond a block"};
  shorter_blocks.block_samples = 100;
  expectBelow(identify(shorter_blocks), 1e-8, 1e-11, 3e-8);
}

}  // namespace
}  // namespace cvg
