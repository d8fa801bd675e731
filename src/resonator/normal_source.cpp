#include "ring_gyro/resonator/normal_source.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "ring_gyro/common/vector_dispatch.h"

namespace cvg {
namespace {

constexpr std::size_t kLanes = NormalSource::kLanes;

inline float asFloat(std::uint32_t bits) {
  float value;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

inline std::uint32_t asBits(float value) {
  std::uint32_t bits;
  std::memcpy(&bits, &value, sizeof bits);
  return bits;
}

inline std::uint32_t rotated(std::uint32_t value, int by) {
  return (value << by) | (value >> (32 - by));
}

// One step of xoshiro128++ (Blackman and Vigna) in each lane.
inline void draw(std::uint32_t* state, std::uint32_t* result) {
  for (std::size_t k = 0; k < kLanes; ++k) {
    std::uint32_t s0 = state[k];
    std::uint32_t s1 = state[k + kLanes];
    std::uint32_t s2 = state[k + 2 * kLanes];
    std::uint32_t s3 = state[k + 3 * kLanes];
    result[k] = rotated(s0 + s3, 7) + s0;
    const std::uint32_t t = s1 << 9;
    s2 ^= s0;
    s3 ^= s1;
    s1 ^= s2;
    s0 ^= s3;
    s2 ^= t;
    s3 = rotated(s3, 11);
    state[k] = s0;
    state[k + kLanes] = s1;
    state[k + 2 * kLanes] = s2;
    state[k + 3 * kLanes] = s3;
  }
}

// -2 ln(u) for the uniform number u in (0, 1] given by the high 31 bits. The polynomials here and
// below are those of Moshier's cephes, accurate to the second last bit.
inline float minusTwiceLog(std::uint32_t bits) {
  const float u = static_cast<float>(static_cast<std::int32_t>(bits >> 1)) * 0x1p-31F + 0x1p-32F;
  // u = m 2^e with m between sqrt(1/2) and sqrt(2).
  const auto raw = static_cast<std::int32_t>(asBits(u));
  const std::int32_t exponent = (raw - 0x3f3504f3) >> 23;
  const float f = asFloat(static_cast<std::uint32_t>(raw - exponent * 0x800000)) - 1.0F;
  const float q = f * f;
  float series = 7.0376836292e-2F;
  series = series * f - 1.1514610310e-1F;
  series = series * f + 1.1676998740e-1F;
  series = series * f - 1.2420140846e-1F;
  series = series * f + 1.4249322787e-1F;
  series = series * f - 1.6668057665e-1F;
  series = series * f + 2.0000714765e-1F;
  series = series * f - 2.4999993993e-1F;
  series = series * f + 3.3333331174e-1F;
  const float log_m = f + (f * q * series - 0.5F * q);
  return -2.0F * (static_cast<float>(exponent) * 0.69314718056F + log_m);
}

RING_GYRO_VECTOR_CLONES
void drawNormals(std::uint32_t* state, float* normals, std::size_t count) {
  for (std::size_t j = 0; j < count; j += 2 * kLanes) {
    std::uint32_t radius_bits[kLanes];
    std::uint32_t angle_bits[kLanes];
    draw(state, radius_bits);
    draw(state, angle_bits);
    float* const xs = normals + j;
    float* const ys = xs + kLanes;
    for (std::size_t k = 0; k < kLanes; ++k) {
      const float radius = std::sqrt(minusTwiceLog(radius_bits[k]));
      // An angle within 45 degrees of the x axis; the low bits then swap and mirror it to all
      // octants.
      const std::uint32_t bits = angle_bits[k];
      const float v =
          static_cast<float>(static_cast<std::int32_t>(bits >> 8)) * 0x1p-24F - (0.5F - 0x1p-25F);
      const float w = 1.5707963268F * v;
      const float q = w * w;
      float sine = -1.9515295891e-4F;
      sine = sine * q + 8.3321608736e-3F;
      sine = sine * q - 1.6666654611e-1F;
      sine = sine * q * w + w;
      float cosine = 2.443315711809948e-5F;
      cosine = cosine * q - 1.388731625493765e-3F;
      cosine = cosine * q + 4.166664568298827e-2F;
      cosine = cosine * q - 0.5F;
      cosine = cosine * q + 1.0F;
      const std::uint32_t swap = 0U - (bits & 1U);
      const std::uint32_t s = asBits(sine);
      const std::uint32_t c = asBits(cosine);
      const std::uint32_t differing = (s ^ c) & swap;
      xs[k] = radius * asFloat((c ^ differing) ^ ((bits & 2U) << 30));
      ys[k] = radius * asFloat((s ^ differing) ^ ((bits & 4U) << 29));
    }
  }
}

RING_GYRO_VECTOR_CLONES
void addScaled(const double* samples, const float* normals, double sigma, std::size_t count,
               double* sums) {
  for (std::size_t k = 0; k < count; ++k) {
    sums[k] = samples[k] + sigma * static_cast<double>(normals[k]);
  }
}

// Fills the states from one seed, as recommended by the authors of xoshiro (splitmix64).
std::uint64_t splitMix(std::uint64_t& state) {
  state += 0x9e3779b97f4a7c15ULL;
  std::uint64_t z = state;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

}  // namespace

NormalSource::NormalSource(std::uint64_t seed) {
  for (std::uint32_t& word : state_) word = static_cast<std::uint32_t>(splitMix(seed) >> 32);
}

void NormalSource::refill() {
  drawNormals(state_.data(), batch_.data(), kBatch);
  used_ = 0;
}

double NormalSource::next() {
  if (used_ == kBatch) refill();
  return static_cast<double>(batch_[used_++]);
}

void NormalSource::addTo(const double* samples, std::size_t count, double sigma, double* sums) {
  std::size_t done = 0;
  while (done < count) {
    if (used_ == kBatch) refill();
    const std::size_t run = std::min(count - done, kBatch - used_);
    addScaled(samples + done, batch_.data() + used_, sigma, run, sums + done);
    done += run;
    used_ += run;
  }
}

}  // namespace cvg
