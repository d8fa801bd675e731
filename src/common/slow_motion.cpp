#include "ring_gyro/common/slow_motion.h"

namespace cvg {

Eigen::Matrix2cd slowMotion(double angular_frequency, const Eigen::Matrix2d& damping,
                            const Eigen::Matrix2d& stiffness) {
  // Each pass shrinks the error by about |D| / w0. D = P + i Q in real numbers.
  const double scale = 0.5 / angular_frequency;
  const Eigen::Matrix2d first_p = -0.5 * damping;
  const Eigen::Matrix2d first_q = scale * stiffness;
  Eigen::Matrix2d p_part = first_p;
  Eigen::Matrix2d q_part = first_q;
  for (int pass = 0; pass < 50; ++pass) {
    const Eigen::Matrix2d damped = p_part + damping;
    const Eigen::Matrix2d next_p = first_p - scale * (damped * q_part + q_part * p_part);
    const Eigen::Matrix2d next_q = first_q + scale * (damped * p_part - q_part * q_part);
    const double change = (next_p - p_part).squaredNorm() + (next_q - q_part).squaredNorm();
    p_part = next_p;
    q_part = next_q;
    if (change <= 1e-32 * (p_part.squaredNorm() + q_part.squaredNorm())) break;
  }
  Eigen::Matrix2cd slow;
  slow.real() = p_part;
  slow.imag() = q_part;
  return slow;
}

}  // namespace cvg
