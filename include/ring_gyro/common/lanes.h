#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace cvg {

// Several numbers that are computed side by side. Where a machine's registers are narrower, the
// compiler splits them, so a function marked RING_GYRO_VECTOR_CLONES uses the width of the machine.
// Pass them by reference: how they are passed by value depends on the machine.

using Lanes = double __attribute__((vector_size(64)));
constexpr std::size_t kLanes = sizeof(Lanes) / sizeof(double);
using FourLanes = double __attribute__((vector_size(32)));
using TwoLanes = double __attribute__((vector_size(16)));

/// Integers of the same width.
template <typename Vector>
struct WholeLanes;
template <>
struct WholeLanes<Lanes> {
  using Type = std::uint64_t __attribute__((vector_size(64)));
};
template <>
struct WholeLanes<TwoLanes> {
  using Type = std::uint64_t __attribute__((vector_size(16)));
};
template <>
struct WholeLanes<FourLanes> {
  using Type = std::uint64_t __attribute__((vector_size(32)));
};

template <typename Vector>
inline void load(const double* from, Vector& lanes) {
  std::memcpy(&lanes, from, sizeof lanes);
}
template <typename Vector>
inline void store(const Vector& lanes, double* to) {
  std::memcpy(to, &lanes, sizeof lanes);
}

inline double sumOf(const FourLanes& lanes) {
  return (lanes[0] + lanes[2]) + (lanes[1] + lanes[3]);
}
inline double sumOf(const Lanes& lanes) {
  return ((lanes[0] + lanes[4]) + (lanes[2] + lanes[6])) +
         ((lanes[1] + lanes[5]) + (lanes[3] + lanes[7]));
}

}  // namespace cvg
