#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "ring_gyro/identification/filter/identifier.h"
#include "ring_gyro/ros/identification_report.h"
#include "ring_gyro/ros/message_checks.h"
#include "ring_gyro/ros/messages.h"
#include "ring_gyro/signals/pair_merge.h"
#include "ring_gyro/simulation/loop_configuration.h"

namespace ring_gyro::bridge {

/// From messages to estimates: merge, filter and the report about both. The node and the tools for
/// bags use this same class, so their estimates are the same to the last bit.
class StreamIdentifier {
 public:
  using Sink = std::function<void(const cvg::ParameterEstimate&)>;

  /// `sink` gets each estimate. `start_sequence`: the filter begins with the first pair of this or
  /// a later sequence, like an identifier that was started there. Throws std::invalid_argument,
  /// naming a parameter that cannot be used.
  StreamIdentifier(const cvg::LoopConfiguration& configuration, Sink sink,
                   std::uint64_t start_sequence = 0);
  StreamIdentifier(const StreamIdentifier&) = delete;
  StreamIdentifier& operator=(const StreamIdentifier&) = delete;

  /// Gives the fault of the message, if any; its block is then unusable.
  MessageFault add(const ring_gyro::OrbitalElements& message);
  MessageFault add(const ring_gyro::ControlGains& message);
  void add(const cvg::OrbitalElements& elements) { merge_.add(elements); }
  void add(const cvg::ControlGains& gains) { merge_.add(gains); }
  /// The input has ended.
  void flush();

  /// Stamp of the last pair; null before the first.
  const cvg::BlockStamp* last() const {
    return merge_.counts().pairs > 0 ? &report_.last : nullptr;
  }
  /// Number of elements and gains that wait for their partner.
  std::size_t waiting() const { return merge_.waiting(); }
  IdentificationReport report() const;

 private:
  void process(const cvg::OrbitalElements& elements, const cvg::ControlGains& gains);
  void count(const cvg::OrbitalElements& elements, const cvg::ControlGains& gains);
  void account(const cvg::ParameterEstimate& estimate);

  cvg::Identifier identifier_;
  cvg::PairMerge merge_;
  Sink sink_;
  std::uint64_t start_sequence_;
  std::int64_t block_duration_ns_;
  bool started_ = false;
  cvg::OrbitalElements elements_;
  cvg::ControlGains gains_;
  IdentificationReport report_;
};

}  // namespace ring_gyro::bridge
