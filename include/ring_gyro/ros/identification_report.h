#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "ring_gyro/identification/filter/block_use.h"
#include "ring_gyro/identification/judge/consistency.h"
#include "ring_gyro/signals/pair_merge.h"
#include "ring_gyro/signals/parameter_estimate.h"
#include "ring_gyro/signals/time_guard.h"
#include "ring_gyro/simulation/loop_configuration.h"

namespace ring_gyro::bridge {

/// A reason and how many blocks it was found against.
struct UnusableReason {
  const char* key;   ///< for programs
  const char* text;  ///< for people, after a number
  std::uint64_t blocks;
  bool always;  ///< in reports also when it did not occur
};
/// Every reason, those that never occurred too.
std::vector<UnusableReason> reasonsOf(const cvg::BlockUseCounts& uses);
/// The reason of most, "5500 not locked"; empty when there is none.
std::string mainReasonOf(const cvg::BlockUseCounts& uses);

/// What identification made of a stream of messages, live, replayed or read from a bag.
struct IdentificationReport {
  std::optional<cvg::ParameterEstimate> estimate;  ///< the last
  cvg::BlockStamp first;  ///< first pair that the filter saw, of the last start
  cvg::BlockStamp last;   ///< last pair
  /// Of the last start of the filter: data from its first block until it first said converged [s].
  std::optional<double> convergence_time;
  cvg::NisTally nis;  ///< of the last start; converged: since it first said so
  std::uint64_t filter_restarts = 0;

  cvg::PairMerge::Counts pairs;
  cvg::TimeGuard::Counts elements;
  cvg::TimeGuard::Counts gains;
  std::uint64_t alone_at_start = 0;    ///< part of pairs.*_alone: cut off where recording began
  std::uint64_t alone_at_end = 0;      ///< and where it ended
  std::uint64_t before_start = 0;      ///< pairs before the sequence that was asked for
  cvg::BlockUseCounts uses;            ///< of the pairs, by the identifier's own rule
  std::string first_refused;           ///< the first message with numbers that cannot be, and why
  double frequency_sum = 0.0;          ///< of the NCO over usable blocks [rad/s]
  std::int64_t wrong_duration_ns = 0;  ///< the first duration that was wrong

  std::uint64_t not_delivered = 0;  ///< messages in the bag that its replay did not deliver
};

/// A report, and what it is of.
struct IdentificationResult {
  std::vector<std::string> sources;  ///< bags; empty: a live run
  IdentificationReport report;
  std::vector<std::string> damage;  ///< of the bags, a line each
};

/// What identification came to, as the exit statuses of the tools have it.
enum class Verdict { kIdentified = 0, kFailed = 1, kIdentifiedWithFaults = 2 };
Verdict verdictOf(const IdentificationResult& result, const cvg::LoopConfiguration& configuration);

/// Why there is nothing to rely on, one line with the mend; empty: identified.
std::string failureOf(const IdentificationReport& report,
                      const cvg::LoopConfiguration& configuration);
/// What was wrong with the data although parameters came out, or with their fit, one line each.
std::vector<std::string> faultsOf(const IdentificationReport& report,
                                  const cvg::LoopConfiguration& configuration);

/// A table for people.
std::string identificationText(const IdentificationResult& result,
                               const cvg::LoopConfiguration& configuration);
/// For programs, SI units: {"version": ..., "runs": [one object for each result]}.
std::string identificationJson(const std::vector<IdentificationResult>& results,
                               const cvg::LoopConfiguration& configuration);

}  // namespace ring_gyro::bridge
