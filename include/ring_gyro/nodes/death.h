#pragma once

#include <string>

namespace ring_gyro::nodes {

/// Whether a node (its whole name) was killed or has crashed: the master still knows it, but nobody
/// answers where it was. One that ended in order, as by rosnode kill, the master knows no more.
bool hasDied(const std::string& node);

}  // namespace ring_gyro::nodes
