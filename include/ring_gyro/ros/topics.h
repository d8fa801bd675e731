#pragma once

namespace ring_gyro::bridge::topics {

// Relative names, so that a namespace or a remapping changes them.
constexpr char kDisplacement[] = "displacement";
constexpr char kDriveCommand[] = "drive_command";
constexpr char kOrbitalElements[] = "orbital_elements";
constexpr char kControlGains[] = "control_gains";
constexpr char kImu[] = "imu";
constexpr char kParameterEstimate[] = "parameter_estimate";
constexpr char kCompensationGains[] = "compensation_gains";
constexpr char kCalibrationCommand[] = "calibration_command";
constexpr char kPlantTruth[] = "plant_truth";
constexpr char kEndOfRun[] = "end_of_run";

}  // namespace ring_gyro::bridge::topics
