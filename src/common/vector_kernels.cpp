#include "ring_gyro/common/vector_kernels.h"

#include <cmath>
#include <cstdint>
#include <cstring>

#include "ring_gyro/common/lanes.h"
#include "ring_gyro/common/vector_dispatch.h"

namespace cvg {
namespace {

constexpr std::size_t kWidth = kLanes;
static_assert(kKernelLanes == 2 * kWidth);

using Masks = std::int64_t __attribute__((vector_size(64)));

inline double sumOfLanes(const Lanes& low, const Lanes& high) { return sumOf(Lanes(low + high)); }

// sum += matrix v, with the matrix stored by columns.
inline void addProduct(const FourLanes* matrix, const FourLanes& v, FourLanes& sum) {
  sum = (matrix[0] * v[0] + matrix[1] * v[1]) + (matrix[2] * v[2] + (matrix[3] * v[3] + sum));
}

// The lanes of a phasor that turns by `step` per sample, and its turn over two registers.
struct TurningLanes {
  Lanes cosine0, sine0, cosine1, sine1;
  double cosine_turn, sine_turn;
};

inline void startTurning(double real, double imaginary, double step, TurningLanes& lanes) {
  // Powers of e^{i step}, each from the powers of half its exponent.
  double c[2 * kWidth + 1];
  double s[2 * kWidth + 1];
  c[0] = 1.0;
  s[0] = 0.0;
  c[1] = std::cos(step);
  s[1] = std::sin(step);
  for (std::size_t l = 2; l <= 2 * kWidth; ++l) {
    const std::size_t half = l / 2;
    const std::size_t rest = l - half;
    c[l] = c[half] * c[rest] - s[half] * s[rest];
    s[l] = s[half] * c[rest] + c[half] * s[rest];
  }
  Lanes power_c, power_s;
  load(c, power_c);
  load(s, power_s);
  lanes.cosine0 = power_c * real - power_s * imaginary;
  lanes.sine0 = power_s * real + power_c * imaginary;
  load(c + kWidth, power_c);
  load(s + kWidth, power_s);
  lanes.cosine1 = power_c * real - power_s * imaginary;
  lanes.sine1 = power_s * real + power_c * imaginary;
  lanes.cosine_turn = c[2 * kWidth];
  lanes.sine_turn = s[2 * kWidth];
}

inline void turn(TurningLanes& lanes) {
  const Lanes cosine0 = lanes.cosine0 * lanes.cosine_turn - lanes.sine0 * lanes.sine_turn;
  const Lanes cosine1 = lanes.cosine1 * lanes.cosine_turn - lanes.sine1 * lanes.sine_turn;
  lanes.sine0 = lanes.sine0 * lanes.cosine_turn + lanes.cosine0 * lanes.sine_turn;
  lanes.sine1 = lanes.sine1 * lanes.cosine_turn + lanes.cosine1 * lanes.sine_turn;
  lanes.cosine0 = cosine0;
  lanes.cosine1 = cosine1;
}

}  // namespace

RING_GYRO_VECTOR_CLONES
void samplePhasorSeries(const PhasorSeries& series, const double* share, const double* cosine,
                        const double* sine, std::size_t count, double* x, double* y) {
  const int last = series.terms - 1;
  for (std::size_t j = 0; j < count; j += kWidth) {
    Lanes s;
    load(share + j, s);
    Lanes xr = Lanes{} + series.x_real[last];
    Lanes xi = Lanes{} + series.x_imaginary[last];
    Lanes yr = Lanes{} + series.y_real[last];
    Lanes yi = Lanes{} + series.y_imaginary[last];
    for (int k = last - 1; k >= 0; --k) {
      xr = xr * s + series.x_real[k];
      xi = xi * s + series.x_imaginary[k];
      yr = yr * s + series.y_real[k];
      yi = yi * s + series.y_imaginary[k];
    }
    Lanes c;
    load(cosine + j, c);
    load(sine + j, s);
    store(xr * c - xi * s, x + j);
    store(yr * c - yi * s, y + j);
  }
}

RING_GYRO_VECTOR_CLONES
void mixDown(const double* x, const double* y, double phase, double step, std::size_t count,
             const double* weights, std::size_t kept_from, double* mixed_x_real,
             double* mixed_x_imaginary, double* mixed_y_real, double* mixed_y_imaginary,
             double* sums) {
  TurningLanes phasor;
  startTurning(std::cos(phase), -std::sin(phase), -step, phasor);
  Lanes sum_xr0{}, sum_xr1{}, sum_xi0{}, sum_xi1{}, sum_yr0{}, sum_yr1{}, sum_yi0{}, sum_yi1{};
  double last_x[kKernelLanes] = {};
  double last_y[kKernelLanes] = {};
  for (std::size_t j = 0; j < count; j += kKernelLanes) {
    const double* from_x = x + j;
    const double* from_y = y + j;
    if (j + kKernelLanes > count) {
      std::memcpy(last_x, from_x, (count - j) * sizeof(double));
      std::memcpy(last_y, from_y, (count - j) * sizeof(double));
      from_x = last_x;
      from_y = last_y;
    }
    Lanes x0, x1, y0, y1, w0, w1;
    load(from_x, x0);
    load(from_x + kWidth, x1);
    load(from_y, y0);
    load(from_y + kWidth, y1);
    load(weights + j, w0);
    load(weights + j + kWidth, w1);
    const Lanes wc0 = w0 * phasor.cosine0;
    const Lanes wc1 = w1 * phasor.cosine1;
    const Lanes ws0 = w0 * phasor.sine0;
    const Lanes ws1 = w1 * phasor.sine1;
    sum_xr0 += wc0 * x0;
    sum_xr1 += wc1 * x1;
    sum_xi0 += ws0 * x0;
    sum_xi1 += ws1 * x1;
    sum_yr0 += wc0 * y0;
    sum_yr1 += wc1 * y1;
    sum_yi0 += ws0 * y0;
    sum_yi1 += ws1 * y1;
    if (j + kKernelLanes > kept_from) {
      store(x0 * phasor.cosine0, mixed_x_real + j);
      store(x1 * phasor.cosine1, mixed_x_real + j + kWidth);
      store(x0 * phasor.sine0, mixed_x_imaginary + j);
      store(x1 * phasor.sine1, mixed_x_imaginary + j + kWidth);
      store(y0 * phasor.cosine0, mixed_y_real + j);
      store(y1 * phasor.cosine1, mixed_y_real + j + kWidth);
      store(y0 * phasor.sine0, mixed_y_imaginary + j);
      store(y1 * phasor.sine1, mixed_y_imaginary + j + kWidth);
    }
    turn(phasor);
  }
  sums[0] = sumOfLanes(sum_xr0, sum_xr1);
  sums[1] = sumOfLanes(sum_xi0, sum_xi1);
  sums[2] = sumOfLanes(sum_yr0, sum_yr1);
  sums[3] = sumOfLanes(sum_yi0, sum_yi1);
}

RING_GYRO_VECTOR_CLONES
void addPhasor(double real, double imaginary, double step, std::size_t count, double* out) {
  TurningLanes phasor;
  startTurning(real, imaginary, step, phasor);
  for (std::size_t j = 0; j < count; j += kKernelLanes) {
    Lanes values0, values1;
    load(out + j, values0);
    load(out + j + kWidth, values1);
    store(values0 + phasor.cosine0, out + j);
    store(values1 + phasor.cosine1, out + j + kWidth);
    turn(phasor);
  }
}

RING_GYRO_VECTOR_CLONES
void applyAxisErrors(const AxisErrorKernel& errors, std::size_t count, double* x, double* y) {
  const double gain[4] = {errors.gain[0], errors.gain[1], errors.gain[2], errors.gain[3]};
  for (std::size_t j = 0; j < count; j += kWidth) {
    Lanes xs, ys;
    load(x + j, xs);
    load(y + j, ys);
    xs += errors.cubic * (xs * xs * xs);
    ys += errors.cubic * (ys * ys * ys);
    xs += errors.square * (xs * xs);
    ys += errors.square * (ys * ys);
    store(gain[0] * xs + gain[2] * ys, x + j);
    store(gain[1] * xs + gain[3] * ys, y + j);
  }
}

RING_GYRO_VECTOR_CLONES
std::size_t quantise(double step, double lowest, double highest, std::size_t count,
                     double* values) {
  constexpr double kRound = 6755399441055744.0;  // 1.5 2^52: a sum with it is rounded to an integer
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
  FourLanes e0, e1, e2, e3, hp, hq, output, s;
  std::memcpy(&e0, recurrence.flow, sizeof s);
  std::memcpy(&e1, recurrence.flow + 4, sizeof s);
  std::memcpy(&e2, recurrence.flow + 8, sizeof s);
  std::memcpy(&e3, recurrence.flow + 12, sizeof s);
  std::memcpy(&hp, recurrence.input, sizeof s);
  std::memcpy(&hq, recurrence.input + 4, sizeof s);
  std::memcpy(&output, recurrence.output, sizeof s);
  std::memcpy(&s, state, sizeof s);
  // Two samples at a time with the squared flow: this halves the chain from state to state.
  const FourLanes e[4] = {e0, e1, e2, e3};
  FourLanes d0{}, d1{}, d2{}, d3{}, gp{}, gq{};
  addProduct(e, e0, d0);
  addProduct(e, e1, d1);
  addProduct(e, e2, d2);
  addProduct(e, e3, d3);
  addProduct(e, hp, gp);
  addProduct(e, hq, gq);
  std::size_t j = 0;
  for (; j + 2 <= count; j += 2) {
    const FourLanes read = output * s;
    first[j] = read[0] + read[2];
    second[j] = read[1] + read[3];
    FourLanes next = hp * p[j] + hq * q[j];
    addProduct(e, s, next);
    next *= output;
    first[j + 1] = next[0] + next[2];
    second[j + 1] = next[1] + next[3];
    const FourLanes forced = (gp * p[j] + gq * q[j]) + (hp * p[j + 1] + hq * q[j + 1]);
    s = (d0 * s[0] + d1 * s[1]) + (d2 * s[2] + (d3 * s[3] + forced));
  }
  if (j < count) {
    const FourLanes read = output * s;
    first[j] = read[0] + read[2];
    second[j] = read[1] + read[3];
    FourLanes next = hp * p[j] + hq * q[j];
    addProduct(e, s, next);
    s = next;
  }
  std::memcpy(state, &s, sizeof s);
}

RING_GYRO_VECTOR_CLONES
void runGapRecurrence(const LinearRecurrence& recurrence, const GapNodes& nodes, double* state,
                      const double* p, const double* q, std::size_t count, double* first,
                      double* second) {
  FourLanes e[4], h[2], u[4], v[4], hu[2], hv[2], kick[6], output, s;
  std::memcpy(e, recurrence.flow, sizeof e);
  std::memcpy(h, recurrence.input, sizeof h);
  std::memcpy(u, nodes.flow[0], sizeof u);
  std::memcpy(v, nodes.flow[1], sizeof v);
  std::memcpy(hu, nodes.input[0], sizeof hu);
  std::memcpy(hv, nodes.input[1], sizeof hv);
  std::memcpy(kick, nodes.kick, sizeof kick);
  std::memcpy(&output, recurrence.output, sizeof s);
  std::memcpy(&s, state, sizeof s);
  for (std::size_t j = 0; j < count; ++j) {
    const FourLanes read = output * s;
    first[j] = read[0] + read[2];
    second[j] = read[1] + read[3];
    const FourLanes volts = {p[j], q[j], p[j], q[j]};
    FourLanes at_two = hu[0] * p[j] + hu[1] * q[j];
    FourLanes at_third = hv[0] * p[j] + hv[1] * q[j];
    FourLanes next = h[0] * p[j] + h[1] * q[j];
    addProduct(u, s, at_two);
    addProduct(v, s, at_third);
    addProduct(e, s, next);
    const FourLanes force_two = volts * (at_two * at_two);
    const FourLanes force_third = volts * (at_third * at_third);
    addProduct(kick, force_two, next);
    s = next + (kick[4] * force_third[0] + kick[5] * force_third[1]);
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
  return sumOfLanes(sum0, sum1);
}

RING_GYRO_VECTOR_CLONES
double sumOf(const double* values, std::size_t count) {
  Lanes sum0{};
  Lanes sum1{};
  std::size_t j = 0;
  for (; j + kKernelLanes <= count; j += kKernelLanes) {
    Lanes v0, v1;
    load(values + j, v0);
    load(values + j + kWidth, v1);
    sum0 += v0;
    sum1 += v1;
  }
  double sum = sumOfLanes(sum0, sum1);
  for (; j < count; ++j) sum += values[j];
  return sum;
}

}  // namespace cvg
