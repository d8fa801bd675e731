#include "ring_gyro/common/vector_kernels.h"

#include <cmath>
#include <cstring>

#include "ring_gyro/common/vector_dispatch.h"

namespace ring_gyro {
namespace {

// A register of eight numbers; the compiler splits it where the machine's are narrower.
using Lanes = double __attribute__((vector_size(64)));
constexpr std::size_t kWidth = sizeof(Lanes) / sizeof(double);
static_assert(kKernelLanes == 2 * kWidth);

inline void load(const double* from, Lanes& lanes) { std::memcpy(&lanes, from, sizeof lanes); }
inline void store(const Lanes& lanes, double* to) { std::memcpy(to, &lanes, sizeof lanes); }

}  // namespace

RING_GYRO_VECTOR_CLONES
void samplePhasorSeries(const double* real, const double* imaginary, int terms, const double* share,
                        const double* cosine, const double* sine, std::size_t count, double* out) {
  for (std::size_t j = 0; j < count; j += kKernelLanes) {
    Lanes s0, s1;
    load(share + j, s0);
    load(share + j + kWidth, s1);
    Lanes x0 = Lanes{} + real[terms - 1];
    Lanes y0 = Lanes{} + imaginary[terms - 1];
    Lanes x1 = x0;
    Lanes y1 = y0;
    for (int k = terms - 2; k >= 0; --k) {
      x0 = x0 * s0 + real[k];
      x1 = x1 * s1 + real[k];
      y0 = y0 * s0 + imaginary[k];
      y1 = y1 * s1 + imaginary[k];
    }
    Lanes c0, c1;
    load(cosine + j, c0);
    load(cosine + j + kWidth, c1);
    load(sine + j, s0);
    load(sine + j + kWidth, s1);
    store(x0 * c0 - y0 * s0, out + j);
    store(x1 * c1 - y1 * s1, out + j + kWidth);
  }
}

RING_GYRO_VECTOR_CLONES
void mixDown(const double* x, const double* y, double phase, double step, std::size_t count,
             double* mixed_x_real, double* mixed_x_imaginary, double* mixed_y_real,
             double* mixed_y_imaginary) {
  double c[kWidth];
  double s[kWidth];
  c[0] = std::cos(phase);
  s[0] = -std::sin(phase);
  const double c_one = std::cos(step);
  const double s_one = -std::sin(step);
  for (std::size_t l = 1; l < kWidth; ++l) {
    c[l] = c[l - 1] * c_one - s[l - 1] * s_one;
    s[l] = s[l - 1] * c_one + c[l - 1] * s_one;
  }
  Lanes cosine, sine;
  load(c, cosine);
  load(s, sine);
  const double c_step = std::cos(step * static_cast<double>(kWidth));
  const double s_step = -std::sin(step * static_cast<double>(kWidth));
  for (std::size_t j = 0; j < count; j += kWidth) {
    Lanes xs, ys;
    load(x + j, xs);
    load(y + j, ys);
    store(xs * cosine, mixed_x_real + j);
    store(xs * sine, mixed_x_imaginary + j);
    store(ys * cosine, mixed_y_real + j);
    store(ys * sine, mixed_y_imaginary + j);
    const Lanes turned = cosine * c_step - sine * s_step;
    sine = sine * c_step + cosine * s_step;
    cosine = turned;
  }
}

RING_GYRO_VECTOR_CLONES
double weightedSum(const double* weights, const double* values, std::size_t count) {
  Lanes sum0{};
  Lanes sum1{};
  for (std::size_t j = 0; j < count; j += kKernelLanes) {
    Lanes w0, w1, v0, v1;
    load(weights + j, w0);
    load(weights + j + kWidth, w1);
    load(values + j, v0);
    load(values + j + kWidth, v1);
    sum0 += w0 * v0;
    sum1 += w1 * v1;
  }
  const Lanes sum = sum0 + sum1;
  return ((sum[0] + sum[4]) + (sum[2] + sum[6])) + ((sum[1] + sum[5]) + (sum[3] + sum[7]));
}

}  // namespace ring_gyro
