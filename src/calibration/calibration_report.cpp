#include "ring_gyro/calibration/calibration_report.h"

#include <cmath>

#include "ring_gyro/calibration/rate_parity.h"
#include "ring_gyro/common/angle.h"
#include "ring_gyro/common/formatted.h"

namespace cvg {
namespace {

double degreesPerHour(double rate) { return 3600.0 * toDegrees(rate); }

void addMapKnowledge(std::string& text, const CalibrationResult& result) {
  if (result.angle_map_measured) {
    double largest = 0.0;
    for (int i = 0; i < 720; ++i) {
      const double slope = result.corrections.angle_map.slopeAt(kTwoPi * i / 720);
      largest = std::max(largest, std::abs(slope));
    }
    text +=
        formatted("angle map: measured on the rate table; largest slope error before it %.1f ppm\n",
                  1e6 * largest);
    text += formatted("angular gain k: %.8f\n", result.device.angular_gain);
    return;
  }
  const DrivePath& path = result.corrections.drive_path;
  text +=
      "angle map: not measured, none applied. Steering alone does not show the gain mismatch "
      "and\n";
  text +=
      "  misalignment of the pick-off (2 theta): only their sum with those of the drive, here\n";
  text += formatted(
      "  %.2f %%. Were all of it in the pick-off, the angle scale would be off by %.0f ppm;\n",
      100.0 * std::hypot(path.mismatch, path.skew), 2e6 * std::hypot(path.mismatch, path.skew));
  text += "  where drive and pick-off cancel, by more. A rate table tells.\n";
}

}  // namespace

std::string calibrationText(const CalibrationResult& result) {
  std::string text;
  text += formatted("steering at %.4g deg/s, %.0f s in all\n", toDegrees(result.steering_rate),
                    result.duration);
  text += formatted("%-24s %15s %10s\n", "identified", "value", "sigma");
  for (const IdentifiedParameter& parameter : result.parameters) {
    text += formatted("%-24s % 15.8g %10.1e\n", parameter.name.c_str(), parameter.value,
                      parameter.sigma);
  }
  text += '\n';
  text += formatted("%-24s %15s %15s\n", "drift left, round", "p-p [deg/s]", "sigma [deg/h]");
  int number = 0;
  for (const DriftRound& round : result.drift_rounds) {
    text += formatted("%-24d %15.6f %15.3f\n", ++number, toDegrees(round.peak_to_peak),
                      degreesPerHour(round.sigma));
  }
  text += '\n';
  addMapKnowledge(text, result);
  text += '\n';
  text += formatted("%-14s %12s %12s %12s %12s %12s\n", "rate [deg/s]", "p-p + [deg/s]",
                    "p-p - [deg/s]", "scale + [ppm]", "scale - [ppm]", "drift [deg/h]");
  for (const Verification& v : result.verifications) {
    text += formatted("%-14.4g %12.6f %12.6f %12.2f %12.2f %12.3f\n", toDegrees(v.rate),
                      toDegrees(v.forward_peak), toDegrees(v.backward_peak), 1e6 * v.forward_scale,
                      1e6 * v.backward_scale, degreesPerHour(v.drift_peak_to_peak));
  }
  if (result.threshold) {
    const ThresholdTest& test = *result.threshold;
    text += '\n';
    text += formatted(
        "rate threshold %.6f deg/s (%.2f deg/h); at %.6f deg/s from its worst angle the angle\n",
        toDegrees(test.threshold), degreesPerHour(test.threshold), toDegrees(test.rate));
    text +=
        formatted("  turned by %.5f deg of %.5f deg: %s\n", toDegrees(test.turned),
                  toDegrees(test.expected), test.followed() ? "it follows" : "it does NOT follow");
  }
  return text;
}

}  // namespace cvg
