// Which error of the electronics makes the drift with four times the pattern angle? The paper's
// experiment without noise, its true gamma compensated, each candidate alone.

#include <gtest/gtest.h>

#include <cstdio>
#include <string>
#include <vector>

#include "ring_gyro/analysis/rate_harmonics.h"
#include "ring_gyro/common/angle.h"
#include "ring_gyro/configuration/configuration_reader.h"
#include "ring_gyro/simulation/closed_loop.h"

namespace cvg {
namespace {

struct Drift {
  double second;  // amplitude of 2 theta [deg/s]
  double fourth;  // of 4 theta [deg/s]
};

Drift driftWith(const char* name, const std::vector<std::string>& errors) {
  std::vector<std::string> settings = {"sense/noise_density=0", "sense/cubic=0",
                                       "calibration/gamma1=0.035", "calibration/gamma2=-0.006"};
  settings.insert(settings.end(), errors.begin(), errors.end());
  const LoopConfiguration configuration =
      readConfigurationFile(std::string(RING_GYRO_CONFIG_DIR) + "/paper_experiment.yaml", settings);
  ClosedLoop loop(configuration);
  std::vector<AngleSample> samples;
  while (loop.time() < 45.0) {  // a turn takes 30 s
    const LoopRecord now = loop.step();
    if (loop.time() > 10.0) samples.push_back({loop.time(), now.loops.elements.orbit.theta});
  }
  const RateHarmonics harmonics = fitRateHarmonics(samples);
  const Drift drift{toDegrees(harmonics.amplitude(2)), toDegrees(harmonics.amplitude(4))};
  std::printf("[figure] %-42s drift in 2 theta %.5f deg/s, in 4 theta %.5f deg/s\n", name,
              drift.second, drift.fourth);
  return drift;
}

TEST(FourthHarmonic, ComesFromTheGapNotFromTheSquareLawOfTheDrive) {
  const Drift none = driftWith("no error", {});
  const Drift square = driftWith("square law, bias 25 V", {"drive/bias_voltage=25"});
  const Drift strong = driftWith("square law, bias 1 V", {"drive/bias_voltage=1"});
  const Drift pick_off = driftWith("cubic pick-off 2 %", {"sense/cubic=0.02"});
  const Drift gap = driftWith("drive electrode in the same gap, 6 %", {"drive/gap_cubic=0.06"});
  EXPECT_LT(none.fourth, 1e-4);
  EXPECT_NEAR(square.fourth, none.fourth, 1e-6);
  EXPECT_NEAR(square.second, none.second, 1e-6);
  EXPECT_NEAR(strong.fourth, none.fourth, 1e-4);
  EXPECT_GT(pick_off.fourth, 0.3);
  // A drive f (1 + g u^2) keeps a quarter of g a^2 along and across: (g a^2 / 16) xi0 w0.
  EXPECT_NEAR(gap.fourth, toDegrees(0.06 / 16.0 * kPi * 14195.0 / 22000.0), 0.02);
}

}  // namespace
}  // namespace cvg
