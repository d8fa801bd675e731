#pragma once

#include <Eigen/Core>

namespace cvg {

/// The matrix D [1/s] with which the free envelope against w0 goes, e^{D t}, of
///
///     u'' + C u' + (w0^2 + K) u = 0:
///
/// the small solution of D = i ((D + C) D + i w0 C + K) / (2 w0), the solvent of the quadratic less
/// i w0. `angular_frequency` w0 [rad/s], `damping` C [1/s], `stiffness` K [1/s^2], both small
/// against w0 and w0^2.
Eigen::Matrix2cd slowMotion(double angular_frequency, const Eigen::Matrix2d& damping,
                            const Eigen::Matrix2d& stiffness);

}  // namespace cvg
