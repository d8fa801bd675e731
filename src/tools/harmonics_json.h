#pragma once

#include <nlohmann/json.hpp>

#include "ring_gyro/common/angle_harmonics.h"

namespace ring_gyro::tools {

inline nlohmann::json jsonOf(const cvg::AngleHarmonics& function) {
  return {{"constant", function.constant}, {"cosine", function.cosine}, {"sine", function.sine}};
}

}  // namespace ring_gyro::tools
