#include "ring_gyro/calibration/calibration_report.h"

#include <cmath>
#include <cstdarg>
#include <cstdio>

#include "ring_gyro/calibration/rate_parity.h"
#include "ring_gyro/common/angle.h"

namespace ring_gyro {
namespace {

void addLine(std::string& text, const char* format, ...) {
  char line[256];
  std::va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(line, sizeof line, format, arguments);
  va_end(arguments);
  text += line;
  text += '\n';
}

double degreesPerHour(double rate) { return 3600.0 * toDegrees(rate); }

void addMapKnowledge(std::string& text, const CalibrationResult& result) {
  if (result.angle_map_measured) {
    double largest = 0.0;
    for (int i = 0; i < 720; ++i) {
      const double slope = result.calibration.angle_map.slopeAt(kTwoPi * i / 720);
      largest = std::max(largest, std::abs(slope));
    }
    addLine(text, "angle map: measured on the rate table; largest slope error before it %.1f ppm",
            1e6 * largest);
    addLine(text, "angular gain k: %.8f", result.angular_gain);
    return;
  }
  const DrivePath& path = result.calibration.drive_path;
  addLine(
      text,
      "angle map: not measured, none applied. Steering alone does not show the gain mismatch and");
  addLine(text,
          "  misalignment of the pick-off (2 theta): only their sum with those of the drive, here");
  addLine(text,
          "  %.2f %%. Were all of it in the pick-off, the angle scale would be off by %.0f ppm;",
          100.0 * std::hypot(path.mismatch, path.skew), 2e6 * std::hypot(path.mismatch, path.skew));
  addLine(text, "  where drive and pick-off cancel, by more. A rate table tells.");
}

}  // namespace

std::string calibrationText(const CalibrationResult& result) {
  std::string text;
  addLine(text, "steering at %.4g deg/s, %.0f s in all", toDegrees(result.steering_rate),
          result.duration);
  addLine(text, "%-24s %15s %10s", "identified", "value", "sigma");
  for (const IdentifiedParameter& parameter : result.parameters) {
    addLine(text, "%-24s % 15.8g %10.1e", parameter.name.c_str(), parameter.value, parameter.sigma);
  }
  addLine(text, "");
  addLine(text, "%-24s %15s %15s", "drift left, round", "p-p [deg/s]", "sigma [deg/h]");
  int number = 0;
  for (const DriftRound& round : result.drift_rounds) {
    addLine(text, "%-24d %15.6f %15.3f", ++number, toDegrees(round.peak_to_peak),
            degreesPerHour(round.sigma));
  }
  addLine(text, "");
  addMapKnowledge(text, result);
  addLine(text, "");
  addLine(text, "%-14s %12s %12s %12s %12s %12s", "rate [deg/s]", "p-p + [deg/s]", "p-p - [deg/s]",
          "scale + [ppm]", "scale - [ppm]", "drift [deg/h]");
  for (const Verification& v : result.verifications) {
    addLine(text, "%-14.4g %12.6f %12.6f %12.2f %12.2f %12.3f", toDegrees(v.rate),
            toDegrees(v.forward_peak), toDegrees(v.backward_peak), 1e6 * v.forward_scale,
            1e6 * v.backward_scale, degreesPerHour(v.drift_peak_to_peak));
  }
  if (result.threshold) {
    const ThresholdTest& test = *result.threshold;
    addLine(text, "");
    addLine(text,
            "rate threshold %.6f deg/s (%.2f deg/h); at %.6f deg/s from its worst angle the angle",
            toDegrees(test.threshold), degreesPerHour(test.threshold), toDegrees(test.rate));
    addLine(text, "  turned by %.5f deg of %.5f deg: %s", toDegrees(test.turned),
            toDegrees(test.expected), test.followed() ? "it follows" : "it does NOT follow");
  }
  return text;
}

}  // namespace ring_gyro
