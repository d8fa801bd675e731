#pragma once

#include <Eigen/Core>

namespace cvg {

/// The matrix D [1/s] of the free envelope e^{D t}, relative to e^{i w0 t}, of
///
///     u'' + C u' + (w0^2 + K) u = 0:
///
/// the small solution of D = i ((D + C) D + i w0 C + K) / (2 w0), which is the solvent of the
/// quadratic minus i w0. `angular_frequency` w0 [rad/s]; `damping` C [1/s], small against w0;
/// `stiffness` K [1/s^2], small against w0^2.
Eigen::Matrix2cd slowMotion(double angular_frequency, const Eigen::Matrix2d& damping,
                            const Eigen::Matrix2d& stiffness);

}  // namespace cvg
