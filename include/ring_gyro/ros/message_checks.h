#pragma once

#include <string>

#include "ring_gyro/ros/messages.h"
#include "ring_gyro/signals/calibration_command.h"
#include "ring_gyro/signals/control_gains.h"
#include "ring_gyro/signals/loop_status.h"
#include "ring_gyro/signals/orbital_elements.h"

namespace ring_gyro::bridge {

/// Why a message cannot be used: the first of its fields that cannot be.
struct MessageFault {
  cvg::Refusal kind = cvg::Refusal::kNone;
  const char* field = "";   ///< "reference_phase"
  const char* reason = "";  ///< what is wrong with it, the same for all its values: "is not finite"
  std::string text;         ///< one line: field, value, what is allowed or the mend

  explicit operator bool() const { return kind != cvg::Refusal::kNone; }
};

// The border between messages and the core: every number of every message is looked at here, before
// anything is made of it. No fault: every number is finite and possible, and no square of it
// overflows. What is left to others: stamps that are zero, that repeat or that step back, and
// sessions (cvg::TimeGuard); samples, whose blocks the loops coast over (ControlLoops). A message
// without a fault costs a sum of its fields.

MessageFault faultOf(const ring_gyro::DisplacementBlock& message);
MessageFault faultOf(const ring_gyro::DriveCommand& message);
MessageFault faultOf(const ring_gyro::OrbitalElements& message);
/// The drive must be the sum of its parts, but for rounding, unless all parts are zero.
MessageFault faultOf(const ring_gyro::ControlGains& message);
MessageFault faultOf(const ring_gyro::ParameterEstimate& message);
MessageFault faultOf(const ring_gyro::CompensationGains& message);
MessageFault faultOf(const ring_gyro::CalibrationCommand& message);
MessageFault faultOf(const ring_gyro::PlantTruth& message);

/// A message as the core may see it. With a fault its block is known and unusable, and none of its
/// numbers goes any further.
MessageFault readChecked(const ring_gyro::OrbitalElements& message, cvg::OrbitalElements& elements);
MessageFault readChecked(const ring_gyro::ControlGains& message, cvg::ControlGains& gains);

}  // namespace ring_gyro::bridge
