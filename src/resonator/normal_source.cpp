#include "ring_gyro/resonator/normal_source.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "ring_gyro/common/vector_dispatch.h"

namespace ring_gyro {
namespace {

constexpr std::size_t kLanes = NormalSource::kLanes;

inline double asDouble(std::uint64_t bits) {
  double value;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

inline std::uint64_t asBits(double value) {
  std::uint64_t bits;
  std::memcpy(&bits, &value, sizeof bits);
  return bits;
}

inline std::uint64_t rotated(std::uint64_t value, int by) {
  return (value << by) | (value >> (64 - by));
}

// One step of xoshiro256++ (Blackman and Vigna) in each lane.
inline void draw(std::uint64_t* state, std::uint64_t* result) {
  for (std::size_t k = 0; k < kLanes; ++k) {
    std::uint64_t s0 = state[k];
    std::uint64_t s1 = state[k + kLanes];
    std::uint64_t s2 = state[k + 2 * kLanes];
    std::uint64_t s3 = state[k + 3 * kLanes];
    result[k] = rotated(s0 + s3, 23) + s0;
    const std::uint64_t t = s1 << 17;
    s2 ^= s0;
    s3 ^= s1;
    s1 ^= s2;
    s0 ^= s3;
    s2 ^= t;
    s3 = rotated(s3, 45);
    state[k] = s0;
    state[k + kLanes] = s1;
    state[k + 2 * kLanes] = s2;
    state[k + 3 * kLanes] = s3;
  }
}

// -2 ln(u) for the uniform number u in (0, 1] that the high 52 bits stand for; error below 1e-12.
inline double minusTwiceLog(std::uint64_t bits) {
  const double u = 2.0 - asDouble((bits >> 12) | 0x3ff0000000000000ULL);
  const std::uint64_t raw = asBits(u);
  // The exponent as a double, by the bits of 2^52 + exponent.
  const double exponent = asDouble((raw >> 52) | 0x4330000000000000ULL) - 4503599627371519.0;
  const double mantissa = asDouble((raw & 0x000fffffffffffffULL) | 0x3ff0000000000000ULL);
  const bool upper = mantissa > 1.4142135623730951;
  const double m = upper ? 0.5 * mantissa : mantissa;
  const double e = upper ? exponent + 1.0 : exponent;
  const double s = (m - 1.0) / (m + 1.0);
  const double q = s * s;
  double series = 1.0 / 15.0;
  series = series * q + 1.0 / 13.0;
  series = series * q + 1.0 / 11.0;
  series = series * q + 1.0 / 9.0;
  series = series * q + 1.0 / 7.0;
  series = series * q + 1.0 / 5.0;
  series = series * q + 1.0 / 3.0;
  series = series * q + 1.0;
  return -2.0 * (e * 0.6931471805599453 + 2.0 * s * series);
}

RING_GYRO_VECTOR_CLONES
void drawNormals(std::uint64_t* state, double* normals) {
  std::uint64_t radius_bits[kLanes];
  std::uint64_t angle_bits[kLanes];
  draw(state, radius_bits);
  draw(state, angle_bits);
  for (std::size_t k = 0; k < kLanes; ++k) {
    const double radius = std::sqrt(minusTwiceLog(radius_bits[k]));
    // An angle within 45 degrees of the x axis; the low bits then swap and mirror it all around.
    const double v = asDouble((angle_bits[k] >> 12) | 0x3ff0000000000000ULL) - 1.5;
    const double w = 1.5707963267948966 * v;
    const double q = w * w;
    double sine = 1.0 / 6227020800.0;
    sine = sine * q - 1.0 / 39916800.0;
    sine = sine * q + 1.0 / 362880.0;
    sine = sine * q - 1.0 / 5040.0;
    sine = sine * q + 1.0 / 120.0;
    sine = sine * q - 1.0 / 6.0;
    sine = sine * q * w + w;
    double cosine = -1.0 / 87178291200.0;
    cosine = cosine * q + 1.0 / 479001600.0;
    cosine = cosine * q - 1.0 / 3628800.0;
    cosine = cosine * q + 1.0 / 40320.0;
    cosine = cosine * q - 1.0 / 720.0;
    cosine = cosine * q + 1.0 / 24.0;
    cosine = cosine * q - 0.5;
    cosine = cosine * q + 1.0;
    const bool swap = (angle_bits[k] & 1U) != 0;
    const double x = radius * (swap ? sine : cosine);
    const double y = radius * (swap ? cosine : sine);
    normals[k] = asDouble(asBits(x) ^ ((angle_bits[k] & 2U) << 62));
    normals[k + kLanes] = asDouble(asBits(y) ^ ((angle_bits[k] & 4U) << 61));
  }
}

// Fills the states from one seed, as the authors of xoshiro advise (splitmix64).
std::uint64_t splitMix(std::uint64_t& state) {
  state += 0x9e3779b97f4a7c15ULL;
  std::uint64_t z = state;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

}  // namespace

NormalSource::NormalSource(std::uint64_t seed) {
  for (std::uint64_t& word : state_) word = splitMix(seed);
}

double NormalSource::next() {
  if (used_ == kBatch) {
    drawNormals(state_.data(), batch_.data());
    used_ = 0;
  }
  return batch_[used_++];
}

void NormalSource::addTo(double* samples, std::size_t count, double sigma) {
  std::size_t done = 0;
  while (done < count) {
    if (used_ == kBatch) {
      drawNormals(state_.data(), batch_.data());
      used_ = 0;
    }
    const std::size_t run = std::min(count - done, kBatch - used_);
    for (std::size_t k = 0; k < run; ++k) samples[done + k] += sigma * batch_[used_ + k];
    done += run;
    used_ += run;
  }
}

}  // namespace ring_gyro
