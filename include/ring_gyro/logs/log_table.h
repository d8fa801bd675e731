#pragma once

#include <string>

#include "ring_gyro/signals/control_gains.h"
#include "ring_gyro/signals/orbital_elements.h"

namespace cvg {

/// Header of the table that LogImporter reads back to the same bits: the columns of the simplest
/// form first (t, a, b, theta, phi, omega, beta, alpha, SI), then the other drives and block data.
std::string logHeader();
/// Appends one row and its line end.
void appendLogRow(const OrbitalElements& elements, const ControlGains& gains, std::string& text);

}  // namespace cvg
