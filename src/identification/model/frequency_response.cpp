#include "ring_gyro/identification/model/frequency_response.h"

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <complex>
#include <stdexcept>
#include <string>

#include "ring_gyro/common/angle.h"
#include "ring_gyro/common/slow_motion.h"

namespace cvg {
namespace {

using Complex = std::complex<double>;
constexpr Complex kI{0.0, 1.0};
constexpr double kRingDownLag = 0.05;  // [s]; for modes within 10 Hz of the reference

double peakFrequency(const std::vector<FrequencyPoint>& points) {
  const auto peak = std::max_element(
      points.begin(), points.end(),
      [](const auto& a, const auto& b) { return a.response.norm() < b.response.norm(); });
  return peak->frequency;
}

std::array<Complex, 2> eigenvalues(const Eigen::Matrix2cd& matrix) {
  const Complex middle = 0.5 * matrix.trace();
  const Complex half = std::sqrt(middle * middle - matrix.determinant());
  return {middle - half, middle + half};
}

// Modes whose envelopes relative to `reference` [rad/s] are proportional to e^{rate t}; lower
// frequency first.
std::array<VibrationMode, 2> modesOf(const std::array<Complex, 2>& rates, double reference) {
  std::array<VibrationMode, 2> modes;
  for (std::size_t k = 0; k < 2; ++k) {
    if (!(rates[k].real() < 0.0)) {
      throw std::invalid_argument("a mode does not decay; is the drive switched off?");
    }
    const double w = reference + rates[k].imag();
    modes[k] = {w / kTwoPi, -0.5 * w / rates[k].real()};
  }
  if (modes[0].frequency > modes[1].frequency) std::swap(modes[0], modes[1]);
  return modes;
}

double peakGain(const std::vector<FrequencyPoint>& points) {
  std::size_t top = 0;
  for (std::size_t k = 1; k < points.size(); ++k) {
    if (std::abs(points[k].response(0, 0)) > std::abs(points[top].response(0, 0))) top = k;
  }
  return std::abs(points[top].response(0, 0));
}

}  // namespace

FrequencyResponseFit fitFrequencyResponse(const std::vector<FrequencyPoint>& points) {
  if (points.size() < 5) {
    throw std::invalid_argument("frequency response: " + std::to_string(points.size()) +
                                " points; at least 5 about the resonance are needed");
  }
  const double reference = kTwoPi * peakFrequency(points);
  // The unknowns are P (2x2) and c in H^-1 = P - c (w^2 - w_r^2) with P = c (K - w_r^2 + i w_r C);
  // each point has the weight 1 / |H^-1|. The term c i (w - w_r) C is small over a resonance and is
  // added by repeating the fit.
  const auto count = static_cast<Eigen::Index>(points.size());
  Eigen::Matrix2cd damping = Eigen::Matrix2cd::Zero();
  Eigen::Matrix2cd constant;
  Complex inverse_gain = 0.0;
  double residual = 0.0;
  for (int pass = 0; pass < 4; ++pass) {
    Eigen::MatrixXcd equations = Eigen::MatrixXcd::Zero(4 * count, 5);
    Eigen::VectorXcd right(4 * count);
    for (Eigen::Index n = 0; n < count; ++n) {
      const FrequencyPoint& point = points[static_cast<std::size_t>(n)];
      const double w = kTwoPi * point.frequency;
      const Eigen::Matrix2cd inverse = point.response.inverse();
      const double weight = 1.0 / inverse.norm();
      const Eigen::Matrix2cd corrected = inverse - inverse_gain * kI * (w - reference) * damping;
      for (Eigen::Index k = 0; k < 4; ++k) {
        const Eigen::Index row = 4 * n + k;
        equations(row, k) = weight;
        if (k == 0 || k == 3) equations(row, 4) = -weight * (w - reference) * (w + reference);
        right[row] = weight * corrected(k / 2, k % 2);
      }
    }
    // The columns have very different sizes: scale them for the factorisation.
    const Eigen::VectorXd scale = equations.colwise().norm();
    const Eigen::VectorXcd scaled =
        (equations * scale.cwiseInverse().asDiagonal()).colPivHouseholderQr().solve(right);
    const Eigen::VectorXcd solution = scale.cwiseInverse().asDiagonal() * scaled;
    residual = (equations * solution - right).norm() / std::sqrt(static_cast<double>(count));
    constant << solution[0], solution[1], solution[2], solution[3];
    inverse_gain = solution[4];
    const Eigen::Matrix2cd matrix = constant / inverse_gain;
    damping = (matrix.imag() / reference).cast<Complex>();
  }
  const Eigen::Matrix2cd matrix = constant / inverse_gain;
  const Eigen::Matrix2d full_stiffness =
      matrix.real() + reference * reference * Eigen::Matrix2d::Identity();
  const Eigen::Matrix2d stiffness = 0.5 * (full_stiffness + full_stiffness.transpose());
  const Eigen::Matrix2d full_damping = matrix.imag() / reference;
  const Eigen::Matrix2d friction = 0.5 * (full_damping + full_damping.transpose());

  FrequencyResponseFit fit;
  const double w0_squared = 0.5 * stiffness.trace();
  const double w0 = std::sqrt(w0_squared);
  const double decay = 0.5 * friction.trace();  // 2 xi0 w0
  fit.natural_frequency = w0 / kTwoPi;
  fit.quality_factor = w0 / decay;
  fit.device.gamma1 = 0.5 * (friction(0, 0) - friction(1, 1)) / decay;
  fit.device.gamma2 = friction(0, 1) / decay;
  fit.device.mu1 = 0.5 * (stiffness(0, 0) - stiffness(1, 1)) / w0_squared;
  fit.device.mu2 = stiffness(0, 1) / w0_squared;
  fit.device.drive_gain = 1.0 / std::abs(inverse_gain);
  fit.phase_delay = std::arg(inverse_gain);
  const Eigen::Matrix2d mismatch = stiffness - w0_squared * Eigen::Matrix2d::Identity();
  fit.modes = modesOf(eigenvalues(slowMotion(w0, friction, mismatch)), w0);
  fit.split = fit.modes[1].frequency - fit.modes[0].frequency;
  fit.drive_gain_peak = w0_squared / fit.quality_factor * peakGain(points);
  fit.residual = residual;
  return fit;
}

std::array<VibrationMode, 2> fitRingDown(const RingDown& ring_down) {
  // Over a lag of many samples the motion changes by much more than the noise.
  const auto lag =
      static_cast<std::size_t>(std::max(1.0, std::round(kRingDownLag / ring_down.period)));
  // Instrumental variables: products of envelopes with independent noise, so that the noise gives
  // no bias.
  Eigen::Matrix2cd ahead = Eigen::Matrix2cd::Zero();   // sum of E(t + 2 lag) E(t)^H
  Eigen::Matrix2cd now = Eigen::Matrix2cd::Zero();     // sum of E(t + lag) E(t)^H
  Eigen::Matrix2cd energy = Eigen::Matrix2cd::Zero();  // sum of E(t) E(t)^H
  for (const auto& run : ring_down.runs) {
    for (std::size_t k = 0; k + 2 * lag < run.size(); ++k) {
      ahead += run[k + 2 * lag] * run[k].adjoint();
      now += run[k + lag] * run[k].adjoint();
      energy += run[k] * run[k].adjoint();
    }
  }
  const std::array<Complex, 2> powers = eigenvalues(energy);
  const double weaker = std::min(powers[0].real(), powers[1].real());
  const double stronger = std::max(powers[0].real(), powers[1].real());
  if (!(weaker > 1e-6 * stronger)) {
    throw std::invalid_argument(
        "ring-down: only one mode was excited; start one run along x and one along y");
  }
  std::array<Complex, 2> rates = eigenvalues(ahead * now.inverse());
  for (Complex& rate : rates) rate = std::log(rate) / (static_cast<double>(lag) * ring_down.period);
  return modesOf(rates, kTwoPi * ring_down.frequency);
}

}  // namespace cvg
