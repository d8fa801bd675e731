#pragma once

#include <diagnostic_updater/DiagnosticStatusWrapper.h>

#include <chrono>
#include <cstdint>
#include <map>
#include <string>

#include "ring_gyro/ros/message_checks.h"

namespace ring_gyro::nodes {

/// What a node has refused of its input: counted by reason, said once and then at most each
/// ten seconds of wall time, shown on /diagnostics.
class Refusals {
 public:
  /// `block`: sequence that the message is of.
  void add(const std::string& topic, std::uint64_t block, const bridge::MessageFault& fault);
  /// A message with good numbers that cannot be used. `reason`: the same for all such messages of
  /// the topic, as "of another session"; `text`: one line with the particulars.
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
