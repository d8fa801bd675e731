#pragma once

#include <Eigen/Core>
#include <cmath>

namespace cvg {

/// Learns what a loop has to do at each pattern angle and does it ahead of the loop.
///
/// Stiffness mismatch makes the quadrature and the resonance swing with cos 2 theta and sin 2
/// theta. While the pattern turns, a loop that corrects this by itself lags, and the rest of b
/// turns the pattern by b mu w0. The loop's own output is moved, at `learning_rate` [1/s], into the
/// amplitudes of 1, cos 2 theta and sin 2 theta, until the loop has nothing of them left to do.
class PatternFeedforward {
 public:
  /// `period`: of the updates [s].
  PatternFeedforward(double learning_rate, double period)
      : step_(learning_rate * period * Eigen::Vector3d(1.0, 2.0, 2.0)) {}

  /// Forgets everything.
  void reset() { amplitudes_.setZero(); }

  /// Adds a constant to what is known, in the unit of the loop's output.
  void addConstant(double constant) { amplitudes_[0] += constant; }

  /// What is known at pattern angle `theta` [rad], in the unit of the loop's output.
  double at(double theta) const { return amplitudes_.dot(harmonics(theta)); }

  /// `loop_output`: what the loop still added by itself at this angle.
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
