#pragma once

#include <Eigen/Core>

namespace cvg {

/// Complex amplitudes of x and y: a signal s(t) = Re[envelope e^{i psi(t)}], psi the phase of the
/// NCO.
using Envelope = Eigen::Vector2cd;

}  // namespace cvg
