#include "ring_gyro/nodes/use_watch.h"

namespace ring_gyro::nodes {

std::string UseWatch::noneSinceLast(std::uint64_t usable, const bridge::UnusableBlocks& unusable) {
  const bool any_usable = usable != usable_;
  const bridge::UnusableBlocks recent = unusable - unusable_;
  usable_ = usable;
  unusable_ = unusable;
  if (any_usable || recent.total() == 0) return "";
  return "none of the last " + std::to_string(recent.total()) +
         " blocks can be used: " + bridge::mainReasonOf(recent);
}

void UseWatch::addTo(diagnostic_updater::DiagnosticStatusWrapper& status, std::uint64_t usable,
                     const bridge::UnusableBlocks& unusable) {
  status.add("usable blocks", usable);
  status.add("unusable blocks", unusable.total());
  for (const bridge::UnusableReason& reason : bridge::reasonsOf(unusable)) {
    status.add(std::string("blocks ") + reason.text, reason.blocks);
  }
}

}  // namespace ring_gyro::nodes
