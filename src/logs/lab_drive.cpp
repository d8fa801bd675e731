#include "ring_gyro/logs/lab_drive.h"

#include <cmath>
#include <complex>
#include <stdexcept>

#include "ring_gyro/control/drive_synthesis.h"

namespace cvg {
namespace {

double valueOrZero(const LogRow& row, Quantity quantity) {
  const double value = valueOf(row, quantity);
  return std::isnan(value) ? 0.0 : value;
}

}  // namespace

LabDrive::LabDrive(const ColumnMap& map, std::optional<double> drive_gain)
    : envelopes_(map.hasDriveEnvelopes()), drive_gain_(drive_gain) {}

void LabDrive::rebuild(const LogRow& row, const Orbit& orbit, ControlGains& target) const {
  target.reference_frequency = valueOf(row, Quantity::kOmega);
  target.beta = valueOrZero(row, Quantity::kBeta);
  target.alpha = valueOrZero(row, Quantity::kAlpha);
  target.virtual_rate = valueOrZero(row, Quantity::kVirtualRate);
  target.compensation = {valueOrZero(row, Quantity::kCompensationGain1),
                         valueOrZero(row, Quantity::kCompensationGain2)};
  target.drive = DriveContributions{};
  if (envelopes_) {
    // The parts are not known: the whole drive is stored as one part.
    using Complex = std::complex<double>;
    target.drive.sustain = {
        Complex(valueOf(row, Quantity::kDriveXReal), valueOf(row, Quantity::kDriveXImag)),
        Complex(valueOf(row, Quantity::kDriveYReal), valueOf(row, Quantity::kDriveYImag))};
    return;
  }
  if (!(orbit.a > 0.0)) return;  // no motion for the gains to act on
  const double speed = target.reference_frequency * orbit.a;
  const double sustain_volts = valueOf(row, Quantity::kSustainVolts);
  const double quadrature_volts = valueOf(row, Quantity::kQuadratureVolts);
  if (!std::isnan(sustain_volts)) target.beta = sustain_volts / speed;
  if (!std::isnan(quadrature_volts)) target.alpha = quadrature_volts / orbit.a;
  if (target.virtual_rate != 0.0 && !drive_gain_) {
    throw std::invalid_argument("virtual_rate steers, but the drive that it stood for is unknown");
  }
  // Steering volts correspond to a virtual rate with any drive gain; it cancels.
  const double drive_gain = drive_gain_.value_or(1.0);
  const double steering_rate =
      0.5 * drive_gain * valueOrZero(row, Quantity::kSteeringVolts) / speed;
  DriveGains gains;
  gains.sustain_force = target.beta * speed;
  gains.alpha = target.alpha;
  gains.virtual_rate = target.virtual_rate + steering_rate;
  gains.compensation = target.compensation;
  target.drive = synthesizeDrive(orbit, gains, target.reference_frequency, drive_gain);
  if (drive_gain_) target.virtual_rate = gains.virtual_rate;
}

}  // namespace cvg
