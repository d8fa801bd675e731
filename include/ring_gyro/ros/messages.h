#pragma once

// The message types under the name ring_gyro_msgs. Generated code puts them into the namespace of
// the package, where the core has its structs of the same names: a DriveCommand is what the loops
// compute, a ring_gyro_msgs::DriveCommand is how it travels. Always include the messages by this
// header; what they include is included first, so that only they are renamed.

#include <ros/message_operations.h>
#include <ros/serialization.h>
#include <ros/types.h>
#include <std_msgs/Header.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

#define ring_gyro ring_gyro_msgs
// clang-format off
#include "ring_gyro/CalibrationCommand.h"
#include "ring_gyro/CompensationGains.h"
#include "ring_gyro/ControlGains.h"
#include "ring_gyro/DisplacementBlock.h"
#include "ring_gyro/DriveCommand.h"
#include "ring_gyro/EndOfRun.h"
#include "ring_gyro/OrbitalElements.h"
#include "ring_gyro/ParameterEstimate.h"
#include "ring_gyro/PlantTruth.h"
// clang-format on
#undef ring_gyro
