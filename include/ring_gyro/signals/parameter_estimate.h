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

/// Covariance of the state, worked out when it is asked for: by the filter, as long as that has not
/// gone on, which is as long as the estimate that carries it is good; a copy holds the numbers.
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
  /// Of `filter`, which gives it as filter.covariance().
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
  /// Not locked, saturated or invalid, or in the period of such a block. Used, rejected and lost
  /// blocks add up to all from first_sequence to stamp.sequence.
  std::uint64_t rejected_blocks = 0;
  std::uint64_t lost_blocks = 0;  ///< gaps in the sequence
  bool updated = false;           ///< whether this period's data entered the estimate
  /// Units of (29). Zero, with the initial variance, until the scale of ks has been found.
  StateVector value = StateVector::Zero();
  ParameterVector parameter_variance = ParameterVector::Zero();
  StateCovariance covariance;  ///< its lower right diagonal is parameter_variance
  /// Of the mean a, b over the period [V]; of its last block while filtering block by block.
  Eigen::Vector2d innovation = Eigen::Vector2d::Zero();
  Eigen::Matrix2d innovation_covariance = Eigen::Matrix2d::Zero();  ///< [V^2]
  double normalised_innovation_squared = 0.0;
  double residual_gamma1 = 0.0;  ///< damping mismatch that the acting compensation leaves
  double residual_gamma2 = 0.0;
  double angle_covered = 0.0;  ///< span of theta seen [rad]
  /// Every sigma below its limit and enough of the angle seen (IdentificationParameters).
  bool converged = false;

  /// Of a parameter. Throws std::out_of_range for kA and kB.
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
