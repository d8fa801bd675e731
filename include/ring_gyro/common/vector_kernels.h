#pragma once

#include <cstddef>

namespace cvg {

/// Loops over the samples of a block, the only code that runs at the converter rate. Each gives the
/// same bits at every vector width of the machine (see vector_dispatch.h).

/// Lengths passed to the kernels are multiples of this: two of the widest registers, so that the
/// processor can work on one while it waits for the result of the other.
constexpr std::size_t kKernelLanes = 16;
constexpr std::size_t paddedToLanes(std::size_t count) {
  return (count + kKernelLanes - 1) / kKernelLanes * kKernelLanes;
}

/// Coefficients of two complex power series; the variable is the fraction of a block.
struct PhasorSeries {
  static constexpr int kMaxTerms = 24;
  int terms = 0;
  double x_real[kMaxTerms];
  double x_imaginary[kMaxTerms];
  double y_real[kMaxTerms];
  double y_imaginary[kMaxTerms];
};

/// x[j] = Re[(cosine[j] + i sine[j]) sum_k (x_real[k] + i x_imaginary[k]) share[j]^k], and the same
/// for y[j].
void samplePhasorSeries(const PhasorSeries& series, const double* share, const double* cosine,
                        const double* sine, std::size_t count, double* x, double* y);

/// Mixes both axes down, mixed_x_real[j] + i mixed_x_imaginary[j] = x[j] e^{-i (phase + step j)}
/// and the same for y, and gives the sums of weights[j] times each of the four. Any `count`. The
/// mixed samples are written from the lanes of sample `kept_from` on, in whole lanes, with zeros
/// after the last sample; `weights` must reach as far.
void mixDown(const double* x, const double* y, double phase, double step, std::size_t count,
             const double* weights, std::size_t kept_from, double* mixed_x_real,
             double* mixed_x_imaginary, double* mixed_y_real, double* mixed_y_imaginary,
             double* sums);

/// out[j] += Re[(real + i imaginary) e^{i step j}].
void addPhasor(double real, double imaginary, double step, std::size_t count, double* out);

/// Errors of two axes: v + square v^2 with v = u + cubic u^3, then the 2x2 gain (by columns).
struct AxisErrorKernel {
  double cubic;
  double square;
  const double* gain;
};
void applyAxisErrors(const AxisErrorKernel& errors, std::size_t count, double* x, double* y);

/// Rounds each value to the nearest multiple of `step`, within [lowest, highest]; gives the number
/// of values that were outside.
std::size_t quantise(double step, double lowest, double highest, std::size_t count, double* values);

/// Four states s under two inputs, s <- flow s + input (p, q), flow and input by columns. The
/// outputs are read before each step: out[0] s[0] + out[2] s[2] and out[1] s[1] + out[3] s[3].
struct LinearRecurrence {
  double flow[16];
  double input[8];
  double output[4];
};
void runRecurrence(const LinearRecurrence& recurrence, double* state, const double* p,
                   const double* q, std::size_t count, double* first, double* second);

/// The same with inputs that also depend on the square of a displacement u within the step, with
/// three nodes of Gauss' rule: u = flow s + input (p, q) at the nodes, in the order
/// x1, y1, x2, y2 | x3, y3, -, -; then for each node kick_k times input times u^2 is added to s.
struct GapNodes {
  double flow[2][16];
  double input[2][8];
  double kick[6][4];
};
void runGapRecurrence(const LinearRecurrence& recurrence, const GapNodes& nodes, double* state,
                      const double* p, const double* q, std::size_t count, double* first,
                      double* second);

/// Sum of weights[j] values[j], from kKernelLanes partial sums.
double weightedSum(const double* weights, const double* values, std::size_t count);

/// Sum of `count` values; any `count`. Finite unless a value is not finite or the sum overflows.
double sumOf(const double* values, std::size_t count);

}  // namespace cvg
