#pragma once

// The message types, ring_gyro::DriveCommand and so on, which carry the signals on topics. The core
// computes with the structs of the same names in the namespace cvg.

#include "ring_gyro/CalibrationCommand.h"
#include "ring_gyro/CompensationGains.h"
#include "ring_gyro/ControlGains.h"
#include "ring_gyro/DisplacementBlock.h"
#include "ring_gyro/DriveCommand.h"
#include "ring_gyro/EndOfRun.h"
#include "ring_gyro/OrbitalElements.h"
#include "ring_gyro/ParameterEstimate.h"
#include "ring_gyro/PlantTruth.h"
#include "ring_gyro/signals/calibration_command.h"
