#pragma once

#include <ros/time.h>
#include <sensor_msgs/Imu.h>

#include <cstdint>
#include <string>

#include "ring_gyro/resonator/plant_simulator.h"
#include "ring_gyro/ros/messages.h"
#include "ring_gyro/signals/calibration_command.h"
#include "ring_gyro/signals/compensation_decision.h"
#include "ring_gyro/signals/control_gains.h"
#include "ring_gyro/signals/displacement_block.h"
#include "ring_gyro/signals/drive_command.h"
#include "ring_gyro/signals/envelope.h"
#include "ring_gyro/signals/orbital_elements.h"
#include "ring_gyro/signals/parameter_estimate.h"

namespace ring_gyro::bridge {

// Core structs to messages and back; both conversions together give the same bits. The target is
// overwritten completely; it is an argument so that its memory is reused.

/// 0 <= nanoseconds < 2^32 s; throws std::runtime_error outside.
ros::Time timeFromNanoseconds(std::int64_t nanoseconds);
std::int64_t nanosecondsFromTime(const ros::Time& time);

void toMessage(const cvg::DisplacementBlock& block, ring_gyro::DisplacementBlock& message);
void fromMessage(const ring_gyro::DisplacementBlock& message, cvg::DisplacementBlock& block);

/// `answered`: stamp of the displacement block that the command answers.
void toMessage(const cvg::DriveCommand& command, const cvg::BlockStamp& answered,
               ring_gyro::DriveCommand& message);
void fromMessage(const ring_gyro::DriveCommand& message, cvg::DriveCommand& command);

void toMessage(const cvg::OrbitalElements& elements, ring_gyro::OrbitalElements& message);
void fromMessage(const ring_gyro::OrbitalElements& message, cvg::OrbitalElements& elements);

void toMessage(const cvg::ControlGains& gains, ring_gyro::ControlGains& message);
/// The drive is the sum of its parts. If all parts of the message are zero, its total is used as
/// the sustain drive.
void fromMessage(const ring_gyro::ControlGains& message, cvg::ControlGains& gains);

void toMessage(const cvg::ParameterEstimate& estimate, ring_gyro::ParameterEstimate& message);
void fromMessage(const ring_gyro::ParameterEstimate& message, cvg::ParameterEstimate& estimate);

/// `data_stamp`: end of the data that the decision was made from.
void toMessage(const cvg::CompensationDecision& decision, const ros::Time& data_stamp,
               ring_gyro::CompensationGains& message);
void fromMessage(const ring_gyro::CompensationGains& message, cvg::CompensationDecision& decision);

/// `data`: stamp of the last block that the command was computed from.
void toMessage(const cvg::CalibrationCommand& command, const cvg::BlockStamp& data,
               ring_gyro::CalibrationCommand& message);
void fromMessage(const ring_gyro::CalibrationCommand& message, cvg::CalibrationCommand& command);

void toMessage(const cvg::PlantTruth& truth, ring_gyro::PlantTruth& message);
void fromMessage(const ring_gyro::PlantTruth& message, cvg::PlantTruth& truth);

/// Rate and angle of the case about z as in REP 145, from a pattern that turns by -k times the
/// rotation. The stamp is the time at which the angle is valid, a group delay before the block's
/// end. Covariances are unknown (zero), there is no accelerometer (-1). `angular_gain`: k.
void toMessage(const cvg::OrbitalElements& elements, double angular_gain, const std::string& frame,
               sensor_msgs::Imu& message);

}  // namespace ring_gyro::bridge
