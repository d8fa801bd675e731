#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <stdexcept>

#include "ring_gyro/signals/block_stamp.h"
#include "ring_gyro/signals/parameter_vector.h"

namespace cvg {

using StateVector = Eigen::Matrix<double, 7, 1>;
using StateMatrix = Eigen::Matrix<double, 7, 7>;

/// States of the identifier, equation (29).
enum StateIndex { kA = 0, kB, kGamma1, kGamma2, kMu1, kMu2, kDriveGain };

/// Covariance of the state, computed only on request, because that takes time. The filter computes
/// it, so the request must come before the filter's next step; until then the estimate that carries
/// it is valid too. A copy contains the numbers.
class StateCovariance {
 public:
  StateCovariance() = default;  ///< zero
  StateCovariance(const StateCovariance& other) : matrix_(other.matrix()) {}
  // NOLINTNEXTLINE(bugprone-unhandled-self-assignment): the filter is not owned
  StateCovariance& operator=(const StateCovariance& other) {
    matrix_ = other.matrix();
    filter_ = nullptr;
    return *this;
  }

  void set(const StateMatrix& matrix) {
    matrix_ = matrix;
    filter_ = nullptr;
  }
  /// Covariance of `filter`, from filter.covariance().
  template <typename Filter>
  void setTo(const Filter& filter) {
    filter_ = &filter;
    work_out_ = [](const void* of) { return static_cast<const Filter*>(of)->covariance(); };
  }

  StateMatrix matrix() const { return filter_ != nullptr ? work_out_(filter_) : matrix_; }

 private:
  StateMatrix matrix_ = StateMatrix::Zero();
  const void* filter_ = nullptr;
  StateMatrix (*work_out_)(const void*) = nullptr;
};

/// Result of one identifier period.
struct ParameterEstimate {
  BlockStamp stamp;                  ///< last block of the period
  std::uint64_t first_sequence = 0;  ///< first block that the identifier saw in this session
  std::uint64_t used_blocks = 0;     ///< since then
  /// Blocks that are not locked, saturated or invalid, and the other blocks of such a period. Used,
  /// rejected and lost blocks together are all blocks from first_sequence to stamp.sequence.
  std::uint64_t rejected_blocks = 0;
  std::uint64_t lost_blocks = 0;  ///< gaps in the sequence
  bool updated = false;           ///< whether this period's data entered the estimate
  /// In the units of (29). Zero, with the initial variance, until the scale of ks has been found.
  StateVector value = StateVector::Zero();
  ParameterVector parameter_variance = ParameterVector::Zero();
  StateCovariance covariance;  ///< its lower right diagonal is parameter_variance
  /// Of the mean a, b over the period [V], or of its last block while the filter runs block by
  /// block.
  Eigen::Vector2d innovation = Eigen::Vector2d::Zero();
  Eigen::Matrix2d innovation_covariance = Eigen::Matrix2d::Zero();  ///< [V^2]
  double normalised_innovation_squared = 0.0;
  double residual_gamma1 = 0.0;  ///< damping mismatch that the acting compensation leaves
  double residual_gamma2 = 0.0;
  double angle_covered = 0.0;  ///< span of theta in the data used [rad]
  /// Every sigma is below its limit and the span of theta is large enough
  /// (IdentificationParameters).
  bool converged = false;

  /// Variance of a parameter. Throws std::out_of_range for kA and kB.
  double variance(StateIndex index) const {
    if (index < kGamma1) {
      throw std::out_of_range("variance of a or b: ask the covariance of the estimate for it");
    }
    return parameter_variance[index - kGamma1];
  }
  double sigma(StateIndex index) const { return std::sqrt(variance(index)); }
  bool isFinite() const { return value.allFinite() && covariance.matrix().allFinite(); }
};

}  // namespace cvg
