#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "ring_gyro/analysis/rate_harmonics.h"
#include "ring_gyro/analysis/run_record.h"

namespace cvg {

/// One identified parameter and its true value.
struct ParameterResult {
  std::string name;
  bool relative = false;  ///< the error is given relative to the truth
  double truth = 0.0;     ///< NaN when unknown
  double estimate = 0.0;
  double sigma = 0.0;

  double error() const { return estimate - truth; }
};

/// Result of the identifier at one time.
struct IdentificationResult {
  double time = 0.0;       ///< since the start of the run [s]
  double used_time = 0.0;  ///< time of the data used in the estimate [s]
  bool converged = false;
  std::array<ParameterResult, 5> parameters;
  double residual_gamma1 = 0.0;  ///< damping mismatch that the acting compensation leaves
  double residual_gamma2 = 0.0;
  double angle_covered = 0.0;  ///< span of theta in the data used [rad]
  std::uint64_t used_blocks = 0;
  std::uint64_t rejected_blocks = 0;
  std::uint64_t lost_blocks = 0;
};

/// Precession rate against angle over a time in which steering and compensation were constant.
struct DriftResult {
  double begin_time = 0.0;                 ///< of the blocks, since the start of the run [s]
  double end_time = 0.0;                   ///< [s]
  double virtual_rate = 0.0;               ///< commanded [rad/s]
  std::optional<RateHarmonics> harmonics;  ///< of theta', times since the start of the run
  std::string missing;                     ///< why there are no harmonics
  std::vector<AngleSample> angles;         ///< measured theta, times since the start of the run
};

/// Largest errors of the true motion, from some time after the first lock to the end.
struct LoopErrors {
  double from_time = 0.0;   ///< since the start of the run [s]
  double phase = 0.0;       ///< |phi + pi/2| [rad]
  double quadrature = 0.0;  ///< |b| / a
  double amplitude = 0.0;   ///< |a - mean of a| / mean of a
};

/// Agreement of the filter's innovations with their expected covariance: the normalised innovation
/// squared of two measurements has the mean 2, and 95 % of its values are below kBound.
struct FilterConsistency {
  static constexpr double kBound = 5.991;  ///< chi squared of two degrees of freedom, 95 %

  std::size_t updates = 0;
  double mean = 0.0;             ///< of the normalised innovation squared
  double share_inside = 0.0;     ///< of updates below kBound
  double meanTolerance() const;  ///< the mean is within 2 +- this in 95 % of consistent runs
};

struct RunSummary {
  double duration = 0.0;               ///< [s]
  std::size_t missing_blocks = 0;      ///< blocks whose elements or gains never arrived
  std::size_t unlocked_blocks = 0;     ///< after the first lock
  std::optional<double> ring_up_time;  ///< from the start until all loops are locked [s]
  std::optional<LoopErrors> loop_errors;
  std::optional<IdentificationResult> before_compensation;  ///< last estimate without compensation
  std::optional<IdentificationResult> final_estimate;
  std::optional<double> converged_time;  ///< the identifier was converged from here to the end [s]
  std::optional<FilterConsistency> consistency;
  /// Why the last estimate does not fit its data; empty if it fits. Judged by the updates from
  /// converged_time on, or by all updates if there are none.
  std::string misfit;
  DriftResult before;  ///< no compensation, all locked
  DriftResult after;   ///< compensation within 1 % of its last value, up to the end
};

struct SummaryOptions {
  double settling = 1.0;     ///< time after the first lock that is not judged [s]
  double rate_window = 0.1;  ///< of the rates [s]
};

RunSummary summarise(const RunRecord& record, const SummaryOptions& options = {});

}  // namespace cvg
