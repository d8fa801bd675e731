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

/// From messages to estimates: merge, filter and the account of both. The node and the tools for
/// bags feed the very same object, which is why their estimates are the same to the last bit.
class StreamIdentifier {
 public:
  using Sink = std::function<void(const cvg::ParameterEstimate&)>;

  /// `sink` gets each estimate. `start_sequence`: the filter sees nothing before the first pair
  /// with this sequence or a later one, as one that was started there.
  /// Throws std::invalid_argument naming what cannot be used.
  StreamIdentifier(const cvg::LoopConfiguration& configuration, Sink sink,
                   std::uint64_t start_sequence = 0);
  StreamIdentifier(const StreamIdentifier&) = delete;
  StreamIdentifier& operator=(const StreamIdentifier&) = delete;

  /// What is wrong with the message; then its block is one that cannot be used.
  MessageFault add(const ring_gyro::OrbitalElements& message);
  MessageFault add(const ring_gyro::ControlGains& message);
  void add(const cvg::OrbitalElements& elements) { merge_.add(elements); }
  void add(const cvg::ControlGains& gains) { merge_.add(gains); }
  /// The input has ended.
  void flush();

  /// Of the last pair; null before the first.
  const cvg::BlockStamp* last() const {
    return merge_.counts().pairs > 0 ? &report_.last : nullptr;
  }
  /// Elements and gains without their partner so far.
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
