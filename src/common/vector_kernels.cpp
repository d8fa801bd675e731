#include "ring_gyro/common/vector_kernels.h"

#include <cmath>
#include <cstdint>
#include <cstring>

#include "ring_gyro/common/vector_dispatch.h"

namespace ring_gyro {
namespace {

// A register of eight numbers; the compiler splits it where the machine's are narrower.
using Lanes = double __attribute__((vector_size(64)));
constexpr std::size_t kWidth = sizeof(Lanes) / sizeof(double);
static_assert(kKernelLanes == 2 * kWidth);

using Masks = std::int64_t __attribute__((vector_size(64)));
using Four = double __attribute__((vector_size(32)));

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
void addPhasor(double real, double imaginary, double step, std::size_t count, double* out) {
  double c[kWidth];
  double s[kWidth];
  c[0] = real;
  s[0] = imaginary;
  const double c_one = std::cos(step);
  const double s_one = std::sin(step);
  for (std::size_t l = 1; l < kWidth; ++l) {
    c[l] = c[l - 1] * c_one - s[l - 1] * s_one;
    s[l] = s[l - 1] * c_one + c[l - 1] * s_one;
  }
  Lanes cosine, sine;
  load(c, cosine);
  load(s, sine);
  const double c_step = std::cos(step * static_cast<double>(kWidth));
  const double s_step = std::sin(step * static_cast<double>(kWidth));
  for (std::size_t j = 0; j < count; j += kWidth) {
    Lanes values;
    load(out + j, values);
    store(values + cosine, out + j);
    const Lanes turned = cosine * c_step - sine * s_step;
    sine = sine * c_step + cosine * s_step;
    cosine = turned;
  }
}

RING_GYRO_VECTOR_CLONES
void readAxes(double cubic, const double* gain, std::size_t count, double* x, double* y) {
  for (std::size_t j = 0; j < count; j += kWidth) {
    Lanes xs, ys;
    load(x + j, xs);
    load(y + j, ys);
    xs += cubic * (xs * xs * xs);
    ys += cubic * (ys * ys * ys);
    store(gain[0] * xs + gain[2] * ys, x + j);
    store(gain[1] * xs + gain[3] * ys, y + j);
  }
}

RING_GYRO_VECTOR_CLONES
std::size_t quantise(double step, double lowest, double highest, std::size_t count,
                     double* values) {
  constexpr double kRound = 6755399441055744.0;  // 1.5 2^52: what is added to it loses its fraction
  const double inverse = 1.0 / step;
  const Lanes low = Lanes{} + lowest;
  const Lanes high = Lanes{} + highest;
  Masks beyond{};
  for (std::size_t j = 0; j < count; j += kWidth) {
    Lanes value;
    load(values + j, value);
    Lanes level = ((value * inverse + kRound) - kRound) * step;
    const Masks under = level < low;
    const Masks over = level > high;
    level = under ? low : level;
    level = over ? high : level;
    beyond += under + over;  // a true lane is -1
    store(level, values + j);
  }
  std::int64_t sum = 0;
  for (std::size_t l = 0; l < kWidth; ++l) sum -= beyond[l];
  return static_cast<std::size_t>(sum);
}

RING_GYRO_VECTOR_CLONES
void runRecurrence(const LinearRecurrence& recurrence, double* state, const double* p,
                   const double* q, std::size_t count, double* first, double* second) {
  Four column[4], input[2], output, s;
  for (std::size_t k = 0; k < 4; ++k) std::memcpy(&column[k], recurrence.flow + 4 * k, sizeof s);
  for (std::size_t k = 0; k < 2; ++k) std::memcpy(&input[k], recurrence.input + 4 * k, sizeof s);
  std::memcpy(&output, recurrence.output, sizeof s);
  std::memcpy(&s, state, sizeof s);
  for (std::size_t j = 0; j < count; ++j) {
    const Four read = output * s;
    first[j] = read[0] + read[2];
    second[j] = read[1] + read[3];
    const Four forced = input[0] * p[j] + input[1] * q[j];
    s = (column[0] * s[0] + column[1] * s[1]) + (column[2] * s[2] + (column[3] * s[3] + forced));
  }
  std::memcpy(state, &s, sizeof s);
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
