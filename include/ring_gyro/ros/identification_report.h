#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "ring_gyro/identification/parameter_estimate.h"
#include "ring_gyro/ros/pair_merge.h"
#include "ring_gyro/ros/time_guard.h"
#include "ring_gyro/simulation/loop_configuration.h"

namespace ring_gyro {

/// Pairs that could not be used, by the first reason found.
struct UnusableBlocks {
  std::uint64_t not_finite = 0;
  std::uint64_t no_amplitude = 0;    ///< a not above |b|: all zero, or no ellipse
  std::uint64_t wrong_duration = 0;  ///< of the block, against the configuration
  std::uint64_t invalid_samples = 0;
  std::uint64_t saturated = 0;  ///< converter or drive
  std::uint64_t not_locked = 0;
};

/// What identification made of a stream of messages, live, replayed or read from a bag.
struct IdentificationReport {
  std::optional<ParameterEstimate> estimate;  ///< the last
  StateMatrix covariance = StateMatrix::Zero();
  BlockStamp first;  ///< first pair that the filter saw, of the last start
  BlockStamp last;   ///< last pair
  /// Of the last start of the filter: data from its first block until it first said converged [s].
  std::optional<double> convergence_time;
  std::uint64_t updates = 0;            ///< estimates with data, of the last start
  double nis_sum = 0.0;                 ///< of their normalised innovations squared
  std::uint64_t updates_converged = 0;  ///< those since it first said converged
  double nis_sum_converged = 0.0;
  std::uint64_t filter_restarts = 0;

  PairMerge::Counts pairs;
  TimeGuard::Counts elements;
  TimeGuard::Counts gains;
  std::uint64_t alone_at_start = 0;  ///< part of pairs.*_alone: cut off where recording began
  std::uint64_t alone_at_end = 0;    ///< and where it ended
  std::uint64_t before_start = 0;    ///< pairs before the sequence that was asked for
  UnusableBlocks unusable;
  double frequency_sum = 0.0;          ///< of the NCO over usable blocks [rad/s]
  std::uint64_t usable = 0;            ///< blocks with nothing wrong
  std::int64_t wrong_duration_ns = 0;  ///< the first duration that was wrong

  std::uint64_t not_delivered = 0;  ///< messages in the bag that its replay did not deliver
};

/// Where a mean normalised innovation squared lies in 95 % of runs of a consistent filter, whose
/// expected value is 2, the degrees of freedom.
struct NisBounds {
  double lower = 0.0;
  double upper = 0.0;
};
NisBounds nisBounds(std::uint64_t updates);

/// A report, and what it is of.
struct IdentificationResult {
  std::vector<std::string> sources;  ///< bags; empty: a live run
  IdentificationReport report;
  std::vector<std::string> damage;  ///< of the bags, a line each
};

/// Why there is nothing to rely on, one line with the mend; empty: identified.
std::string failureOf(const IdentificationReport& report, const LoopConfiguration& configuration);
/// What was wrong with the data although parameters came out, one line each.
std::vector<std::string> faultsOf(const IdentificationReport& report,
                                  const LoopConfiguration& configuration);

/// A table for people.
std::string identificationText(const IdentificationResult& result,
                               const LoopConfiguration& configuration);
/// For programs, SI units: {"version": ..., "runs": [one object for each result]}.
std::string identificationJson(const std::vector<IdentificationResult>& results,
                               const LoopConfiguration& configuration);

}  // namespace ring_gyro
