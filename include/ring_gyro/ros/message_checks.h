#pragma once

#include <string>

#include "ring_gyro/ros/messages.h"
#include "ring_gyro/signals/calibration_command.h"
#include "ring_gyro/signals/control_gains.h"
#include "ring_gyro/signals/loop_status.h"
#include "ring_gyro/signals/orbital_elements.h"

namespace ring_gyro::bridge {

/// Why a message cannot be used: the first of its fields with an impossible value.
struct MessageFault {
  cvg::Refusal kind = cvg::Refusal::kNone;
  const char* field = "";   ///< "reference_phase"
  const char* reason = "";  ///< what is wrong with it, the same for all its values: "is not finite"
  std::string text;         ///< one line: field, value, allowed range or remedy

  explicit operator bool() const { return kind != cvg::Refusal::kNone; }
};

// The border between messages and the core: every number of every message is checked here before it
// is used. No fault means that every number is finite and possible, and that its square does not
// overflow. Not checked here: stamps that are zero, repeat or step back, and sessions
// (cvg::TimeGuard); samples (ControlLoops coasts over such blocks). For a message without a fault
// the check costs one sum of its fields.

MessageFault faultOf(const ring_gyro::DisplacementBlock& message);
MessageFault faultOf(const ring_gyro::DriveCommand& message);
MessageFault faultOf(const ring_gyro::OrbitalElements& message);
/// The drive must be the sum of its parts, except for rounding, unless all parts are zero.
MessageFault faultOf(const ring_gyro::ControlGains& message);
MessageFault faultOf(const ring_gyro::ParameterEstimate& message);
MessageFault faultOf(const ring_gyro::CompensationGains& message);
MessageFault faultOf(const ring_gyro::CalibrationCommand& message);
MessageFault faultOf(const ring_gyro::PlantTruth& message);

/// Converts a message for the core. With a fault the core gets the stamp of the block, marked
/// unusable, and none of the message's numbers.
MessageFault readChecked(const ring_gyro::OrbitalElements& message, cvg::OrbitalElements& elements);
MessageFault readChecked(const ring_gyro::ControlGains& message, cvg::ControlGains& gains);

}  // namespace ring_gyro::bridge
