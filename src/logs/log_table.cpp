#include "ring_gyro/logs/log_table.h"

#include <cstdio>
#include <cstdlib>

#include "ring_gyro/common/formatted.h"
#include "ring_gyro/common/number_text.h"
#include "ring_gyro/logs/quantity.h"
#include "ring_gyro/signals/envelope.h"

namespace cvg {
namespace {

constexpr Quantity kColumns[] = {Quantity::kTime,
                                 Quantity::kA,
                                 Quantity::kB,
                                 Quantity::kTheta,
                                 Quantity::kPhi,
                                 Quantity::kOmega,
                                 Quantity::kBeta,
                                 Quantity::kAlpha,
                                 Quantity::kVirtualRate,
                                 Quantity::kCompensationGain1,
                                 Quantity::kCompensationGain2,
                                 Quantity::kDriveXReal,
                                 Quantity::kDriveXImag,
                                 Quantity::kDriveYReal,
                                 Quantity::kDriveYImag,
                                 Quantity::kReferencePhase,
                                 Quantity::kGroupDelay,
                                 Quantity::kUsable,
                                 Quantity::kSequence};

}  // namespace

std::string logHeader() {
  std::string header;
  for (const Quantity quantity : kColumns) {
    if (!header.empty()) header += ',';
    header += infoOf(quantity).name;
  }
  return header + "\n";
}

void appendLogRow(const OrbitalElements& elements, const ControlGains& gains, std::string& text) {
  // With nanoseconds, which a double cannot hold for a wall-clock time.
  const std::lldiv_t parts = std::lldiv(elements.stamp.end_ns, 1000000000LL);
  text += formatted("%lld.%09lld", parts.quot, parts.rem);
  const auto add = [&text](double value) {
    text += ',';
    appendNumber(text, value);
  };
  const Envelope drive = gains.drive.total();
  add(elements.orbit.a);
  add(elements.orbit.b);
  add(elements.orbit.theta);
  add(elements.orbit.phi);
  add(gains.reference_frequency);
  add(gains.beta);
  add(gains.alpha);
  add(gains.virtual_rate);
  add(gains.compensation.gain1);
  add(gains.compensation.gain2);
  add(drive.x().real());
  add(drive.x().imag());
  add(drive.y().real());
  add(drive.y().imag());
  add(gains.reference_phase);
  add(elements.group_delay);
  text += elements.status.usable() && gains.status.usable() ? ",1," : ",0,";
  text += std::to_string(elements.stamp.sequence);
  text += '\n';
}

}  // namespace cvg
