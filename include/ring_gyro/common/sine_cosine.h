#pragma once

#include <cmath>

#include "ring_gyro/common/lanes.h"
#include "ring_gyro/common/vector_dispatch.h"

namespace cvg {

/// Sines and cosines of one lane after the other, with the library functions.
template <typename Vector>
RING_GYRO_NOT_INLINE void librarySineCosine(const Vector& angle, Vector& sine, Vector& cosine) {
  for (std::size_t i = 0; i < sizeof(Vector) / sizeof(double); ++i) {
    sine[i] = std::sin(angle[i]);
    cosine[i] = std::cos(angle[i]);
  }
}

/// Sines and cosines of several angles [rad] at once, within 2 units of the last place of 1.
/// Library functions compute them one by one, which would take most of the time of a step of the
/// averaged model.
template <typename Vector>
inline void sineCosine(const Vector& angle, Vector& sine, Vector& cosine) {
  using Whole = typename WholeLanes<Vector>::Type;  // casts between the two keep the bits
  constexpr double kLargest = 1e6;  // up to here subtracting the quarter turns is exact enough
  const Whole sign = Whole{} + (std::uint64_t{1} << 63);
  if (!(sumOf((Vector)((Whole)angle & ~sign)) < kLargest)) {  // also if one is NaN
    // On copies: a function argument must be in memory, and only this rare case should pay for it.
    const Vector copy = angle;
    Vector sine_copy, cosine_copy;
    librarySineCosine(copy, sine_copy, cosine_copy);
    sine = sine_copy;
    cosine = cosine_copy;
    return;
  }
  // Adding this number rounds to a whole number, which is then in the last bits of the sum.
  constexpr double kRounder = 6755399441055744.0;  // 1.5 * 2^52
  const Vector shifted = angle * 0.63661977236758134308 + kRounder;
  const Vector quarters = shifted - kRounder;
  // A quarter turn in three parts, the first two short enough for exact products (Cody and Waite).
  const Vector rest =
      ((angle - quarters * 1.57079632673412561417e+00) - quarters * 6.07710050630396597660e-11) -
      quarters * 2.02226624879595063154e-21;
  const Vector square = rest * rest;
  const Vector fourth = square * square;
  // Polynomials of FreeBSD's msun for angles up to an eighth of a turn. The terms are in pairs,
  // which a processor computes in parallel.
  const Vector odd =
      rest +
      rest * square *
          ((-1.66666666666666324348e-01 + square * 8.33333333332248946124e-03) +
           fourth * ((-1.98412698298579493134e-04 + square * 2.75573137070700676789e-06) +
                     fourth * (-2.50507602534068634195e-08 + square * 1.58969099521155010221e-10)));
  const Vector even =
      (1.0 - 0.5 * square) +
      fourth *
          ((4.16666666666666019037e-02 + square * -1.38888888888741095749e-03) +
           fourth * ((2.48015872894767294178e-05 + square * -2.75573143513906633035e-07) +
                     fourth * (2.08757232129817482790e-09 + square * -1.13596475577881948265e-11)));
  // An odd number of quarter turns exchanges sine and cosine, a half turn changes the sign.
  const Whole quarter = (Whole)shifted;
  const Whole exchange = ((Whole)odd ^ (Whole)even) & -(quarter & 1);
  sine = (Vector)(((Whole)odd ^ exchange) ^ ((quarter << 62) & sign));
  cosine = (Vector)(((Whole)even ^ exchange) ^ (((quarter + 1) << 62) & sign));
}

}  // namespace cvg
