#include "logs/other_simulator.h"

#include <cmath>
#include <cstdio>
#include <optional>

#include "logs/log_fixture.h"
#include "ring_gyro/common/angle.h"
#include "ring_gyro/identification/filter/identifier.h"

namespace cvg {
namespace {

class OtherSimulator : public LogTest {};

/// From somebody else's simulator and its log to the device.
TEST_F(OtherSimulator, LogIdentifiesToItsDevice) {
  const other_lab::Device device;
  other_lab::Simulator simulator(device);
  simulator.writeLog(path(), 75.0);

  ImportOptions options;
  options.gain_timing = ImportOptions::GainTiming::kAfter;
  options.drive_gain = other_lab::Simulator::kAssumedKs;
  options.drive_lead = 0.0;
  options.group_delay = simulator.groupDelay();
  options.phi_offset = -0.5 * kPi;
  const ImportedLog log = import({"alpha=-Quad gain"}, options);
  std::printf("%s", log.table.c_str());
  EXPECT_EQ(log.counts.faults.total(), 0U);
  EXPECT_EQ(log.counts.missing_rows, 0U);

  ConverterParameters converter;
  converter.sample_rate = 50e3;
  converter.block_samples = 100;
  Identifier identifier({device.f0, device.q}, IdentificationParameters(), converter);
  std::optional<ParameterEstimate> last;
  for (const auto& [elements, gains] : log.blocks) {
    if (const auto estimate = identifier.process(elements, gains)) last = *estimate;
  }
  ASSERT_TRUE(last);
  const double gamma1 = last->value[kGamma1] - device.gamma1;
  const double gamma2 = last->value[kGamma2] - device.gamma2;
  const double mu1 = last->value[kMu1] - device.mu1;
  const double mu2 = last->value[kMu2] - device.mu2;
  const double ks = last->value[kDriveGain] / device.ks - 1.0;
  std::printf("[figure] other simulator, error of gamma1 % .2e, gamma2 % .2e (limit 2e-4)\n",
              gamma1, gamma2);
  std::printf("[figure] other simulator, error of mu1 % .2e, mu2 % .2e (limit 1e-8)\n", mu1, mu2);
  std::printf("[figure] other simulator, relative error of ks % .2e (limit 1e-3)\n", ks);
  EXPECT_LT(std::abs(gamma1), 2e-4);
  EXPECT_LT(std::abs(gamma2), 2e-4);
  EXPECT_LT(std::abs(mu1), 1e-8);
  EXPECT_LT(std::abs(mu2), 1e-8);
  EXPECT_LT(std::abs(ks), 1e-3);
}

}  // namespace
}  // namespace cvg
