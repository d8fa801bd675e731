#pragma once

#include <Eigen/Core>

namespace cvg {

/// Complex amplitudes of x and y: a signal is s(t) = Re[envelope e^{i psi(t)}], where psi is the
/// phase of the NCO.
using Envelope = Eigen::Vector2cd;

}  // namespace cvg
