#pragma once

#include <string>

namespace ring_gyro::nodes {

/// Whether a node (full name) was killed or has crashed: the master still knows it, but nothing
/// answers at its address. A node that exited normally, also by rosnode kill, is no longer known to
/// the master.
bool hasDied(const std::string& node);

}  // namespace ring_gyro::nodes
