#pragma once

#include <Eigen/Core>
#include <cmath>

namespace cvg {

/// Learns which output a loop needs at each pattern angle and supplies it before the loop reacts.
///
/// Stiffness mismatch makes the quadrature and the resonance swing with cos 2 theta and sin 2
/// theta. While the pattern turns, a loop that corrects this alone lags, and the remaining b
/// turns the pattern by b mu w0. So the loop's own output is moved, at `learning_rate` [1/s], to
/// the amplitudes of 1, cos 2 theta and sin 2 theta, until the loop's own output has none of these
/// left.
class PatternFeedforward {
 public:
  /// `period`: of the updates [s].
  PatternFeedforward(double learning_rate, double period)
      : step_(learning_rate * period * Eigen::Vector3d(1.0, 2.0, 2.0)) {}

  /// Forgets everything.
  void reset() { amplitudes_.setZero(); }

  /// Adds a constant to the learnt output, in the unit of the loop's output.
  void addConstant(double constant) { amplitudes_[0] += constant; }

  /// Learnt output at pattern angle `theta` [rad], in the unit of the loop's output.
  double at(double theta) const { return amplitudes_.dot(harmonics(theta)); }

  /// `loop_output`: the output that the loop still added at this angle.
  void learn(double loop_output, double theta) {
    amplitudes_ += loop_output * step_.cwiseProduct(harmonics(theta));
  }

 private:
  static Eigen::Vector3d harmonics(double theta) {
    return {1.0, std::cos(2.0 * theta), std::sin(2.0 * theta)};
  }

  Eigen::Vector3d step_;
  Eigen::Vector3d amplitudes_ = Eigen::Vector3d::Zero();
};

}  // namespace cvg
