#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ring_gyro/common/parameter_table.h"
#include "ring_gyro/logs/unit.h"

namespace cvg {

/// The possible quantities of a column.
enum class Quantity {
  kTime,
  kA,
  kB,
  kTheta,
  kPhi,
  kOmega,
  kBeta,
  kAlpha,
  kVirtualRate,
  kCompensationGain1,
  kCompensationGain2,
  kSustainVolts,
  kQuadratureVolts,
  kSteeringVolts,
  kDriveXReal,
  kDriveXImag,
  kDriveYReal,
  kDriveYImag,
  kCx,
  kSx,
  kCy,
  kSy,
  kX,
  kY,
  kReferencePhase,
  kGroupDelay,
  kUsable,
  kSequence,
  kCount
};

constexpr std::size_t kQuantityCount = static_cast<std::size_t>(Quantity::kCount);
constexpr std::size_t indexOf(Quantity quantity) { return static_cast<std::size_t>(quantity); }

/// The only place that gives a quantity's name, dimension and meaning.
struct QuantityInfo {
  Quantity quantity;
  const char* name;  ///< as in --column NAME=... and in exported headers
  Dimension dimension;
  const char* meaning;
  Range range;  ///< of possible values, SI: wide, but far below overflow in later arithmetic
  /// Names used by labs: lower case, letters and digits only, each between spaces.
  const char* synonyms;
};

const std::array<QuantityInfo, kQuantityCount>& quantities();
const QuantityInfo& infoOf(Quantity quantity);
std::optional<Quantity> quantityFromName(std::string_view name);
/// The quantity that a header's word (without its unit) is likely to mean.
std::optional<Quantity> guessQuantity(std::string_view word);

}  // namespace cvg
