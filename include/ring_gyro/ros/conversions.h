#pragma once

#include <ros/time.h>
#include <sensor_msgs/Imu.h>

#include <cstdint>
#include <string>

#include "ring_gyro/calibration/calibration_procedure.h"
#include "ring_gyro/compensation/compensation_injector.h"
#include "ring_gyro/control/control_gains.h"
#include "ring_gyro/identification/parameter_estimate.h"
#include "ring_gyro/resonator/displacement_block.h"
#include "ring_gyro/resonator/drive_command.h"
#include "ring_gyro/resonator/plant_simulator.h"
#include "ring_gyro/ros/messages.h"

namespace ring_gyro {

// Core structs to messages and back. There and back gives the same bits. The target is overwritten
// as a whole; it is an argument so that its memory can be used again.

/// 0 <= nanoseconds < 2^32 s; throws std::runtime_error outside.
ros::Time timeFromNanoseconds(std::int64_t nanoseconds);
std::int64_t nanosecondsFromTime(const ros::Time& time);

void toMessage(const DisplacementBlock& block, ring_gyro_msgs::DisplacementBlock& message);
void fromMessage(const ring_gyro_msgs::DisplacementBlock& message, DisplacementBlock& block);

/// `answered`: stamp of the displacement block that the command answers.
void toMessage(const DriveCommand& command, const BlockStamp& answered,
               ring_gyro_msgs::DriveCommand& message);
void fromMessage(const ring_gyro_msgs::DriveCommand& message, DriveCommand& command);

void toMessage(const OrbitalElements& elements, ring_gyro_msgs::OrbitalElements& message);
void fromMessage(const ring_gyro_msgs::OrbitalElements& message, OrbitalElements& elements);

void toMessage(const ControlGains& gains, ring_gyro_msgs::ControlGains& message);
/// The drive is the sum of its parts; a message whose parts are all zero has its total instead,
/// which then stands as the sustain drive.
void fromMessage(const ring_gyro_msgs::ControlGains& message, ControlGains& gains);

void toMessage(const ParameterEstimate& estimate, const StateMatrix& covariance,
               ring_gyro_msgs::ParameterEstimate& message);
void fromMessage(const ring_gyro_msgs::ParameterEstimate& message, ParameterEstimate& estimate);

/// `data_stamp`: end of the data that the decision came from.
void toMessage(const CompensationDecision& decision, const ros::Time& data_stamp,
               ring_gyro_msgs::CompensationGains& message);
void fromMessage(const ring_gyro_msgs::CompensationGains& message, CompensationDecision& decision);

/// `data`: stamp of the last block that the command came from.
void toMessage(const CalibrationCommand& command, const BlockStamp& data,
               ring_gyro_msgs::CalibrationCommand& message);
void fromMessage(const ring_gyro_msgs::CalibrationCommand& message, CalibrationCommand& command);

void toMessage(const PlantTruth& truth, ring_gyro_msgs::PlantTruth& message);
void fromMessage(const ring_gyro_msgs::PlantTruth& message, PlantTruth& truth);

/// Rate and angle of the case about z as REP 145 wants them: of a pattern that turns by -k times
/// the rotation. Stamped when the angle is valid, a group delay before the block's end. Covariances
/// are unknown (zero), there is no accelerometer (-1). `angular_gain`: k.
void toMessage(const OrbitalElements& elements, double angular_gain, const std::string& frame,
               sensor_msgs::Imu& message);

}  // namespace ring_gyro
