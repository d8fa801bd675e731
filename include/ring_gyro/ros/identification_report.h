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

/// A reason why blocks are unusable, and the number of these blocks.
struct UnusableReason {
  const char* key;   ///< for programs
  const char* text;  ///< for printing, after a number
  std::uint64_t blocks;
  bool always;  ///< shown in reports even if it did not occur
};
/// All reasons, including those that did not occur.
std::vector<UnusableReason> reasonsOf(const cvg::BlockUseCounts& uses);
/// The most frequent reason, for example "5500 not locked"; empty when there is none.
std::string mainReasonOf(const cvg::BlockUseCounts& uses);

/// Results of the identification from a stream of messages: live, replayed or read from a bag.
struct IdentificationReport {
  std::optional<cvg::ParameterEstimate> estimate;  ///< the last
  cvg::BlockStamp first;  ///< first pair that the filter got after its last start
  cvg::BlockStamp last;   ///< last pair
  /// Data from the first block after the last start of the filter until it first converged [s].
  std::optional<double> convergence_time;
  cvg::NisTally nis;  ///< since the last start; its converged part: since it first converged
  std::uint64_t filter_restarts = 0;

  cvg::PairMerge::Counts pairs;
  cvg::TimeGuard::Counts elements;
  cvg::TimeGuard::Counts gains;
  std::uint64_t alone_at_start = 0;    ///< part of pairs.*_alone: cut where recording began
  std::uint64_t alone_at_end = 0;      ///< part of pairs.*_alone: cut where recording ended
  std::uint64_t before_start = 0;      ///< pairs before the requested first sequence
  cvg::BlockUseCounts uses;            ///< of the pairs, by the identifier's own rule
  std::string first_refused;           ///< the first message with impossible numbers, and why
  double frequency_sum = 0.0;          ///< of the NCO over usable blocks [rad/s]
  std::int64_t wrong_duration_ns = 0;  ///< the first duration that was wrong

  std::uint64_t not_delivered = 0;  ///< messages in the bag that its replay did not deliver
};

/// A report and its source.
struct IdentificationResult {
  std::vector<std::string> sources;  ///< bags; empty: a live run
  IdentificationReport report;
  std::vector<std::string> damage;  ///< of the bags, a line each
};

/// Result of the identification, as the exit statuses of the tools.
enum class Verdict { kIdentified = 0, kFailed = 1, kIdentifiedWithFaults = 2 };
Verdict verdictOf(const IdentificationResult& result, const cvg::LoopConfiguration& configuration);

/// Why there is no reliable result, in one line with the remedy; empty if identified.
std::string failureOf(const IdentificationReport& report,
                      const cvg::LoopConfiguration& configuration);
/// Faults of the data, or of their fit, although parameters were identified; one line each.
std::vector<std::string> faultsOf(const IdentificationReport& report,
                                  const cvg::LoopConfiguration& configuration);

/// A printed table.
std::string identificationText(const IdentificationResult& result,
                               const cvg::LoopConfiguration& configuration);
/// For programs, SI units: {"version": ..., "runs": [one object for each result]}.
std::string identificationJson(const std::vector<IdentificationResult>& results,
                               const cvg::LoopConfiguration& configuration);

}  // namespace ring_gyro::bridge
