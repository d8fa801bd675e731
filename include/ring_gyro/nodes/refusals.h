#pragma once

#include <diagnostic_updater/DiagnosticStatusWrapper.h>

#include <chrono>
#include <cstdint>
#include <map>
#include <string>

#include "ring_gyro/ros/message_checks.h"

namespace ring_gyro::nodes {

/// Messages that a node has refused: counted by reason, reported at once and then at most every
/// ten seconds of wall time, shown on /diagnostics.
class Refusals {
 public:
  /// `block`: sequence of the message.
  void add(const std::string& topic, std::uint64_t block, const bridge::MessageFault& fault);
  /// A message with possible numbers that cannot be used. `reason`: the same for all such messages
  /// of the topic, for example "of another session"; `text`: one line with details.
  void add(const std::string& topic, const std::string& reason, const std::string& text);

  std::uint64_t total() const { return total_; }
  void addTo(diagnostic_updater::DiagnosticStatusWrapper& status) const;

 private:
  using WallClock = std::chrono::steady_clock;
  struct Kind {
    std::uint64_t count = 0;
    WallClock::time_point said_at;
  };

  std::uint64_t total_ = 0;
  std::map<std::string, Kind> kinds_;
};

}  // namespace ring_gyro::nodes
