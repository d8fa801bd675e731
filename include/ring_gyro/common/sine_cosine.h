#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace ring_gyro {

/// Sines and cosines of a few angles.
template <int Count>
struct SineCosine {
  Eigen::Array<double, Count, 1> sine;
  Eigen::Array<double, Count, 1> cosine;
};

/// Sines and cosines of several angles [rad] side by side, within 2 units of the last place of 1;
/// the same bits on every machine. Library functions take them one by one, which is most of the
/// time of a step of the averaged model.
template <int Count>
SineCosine<Count> sineCosine(const Eigen::Array<double, Count, 1>& angle) {
  using Values = Eigen::Array<double, Count, 1>;
  constexpr double kLargest = 1e6;  // up to here the quarter turns can be taken off exactly enough
  SineCosine<Count> result;
  if (!(angle.abs().maxCoeff() < kLargest)) {
    result.sine = angle.sin();
    result.cosine = angle.cos();
    return result;
  }
  // Adding this rounds to a whole number, which then stands in the last bits.
  constexpr double kRounder = 6755399441055744.0;  // 1.5 * 2^52
  const Values shifted = angle * 0.63661977236758134308 + kRounder;
  const Values quarters = shifted - kRounder;
  // A quarter turn in three parts, the first two short enough for exact products (Cody and Waite).
  const Values rest =
      ((angle - quarters * 1.57079632673412561417e+00) - quarters * 6.07710050630396597660e-11) -
      quarters * 2.02226624879595063154e-21;
  const Values square = rest * rest;
  const Values fourth = square * square;
  // Polynomials of FreeBSD's msun for up to an eighth of a turn, in pairs of terms, which a
  // processor does side by side.
  const Values sine =
      rest +
      rest * square *
          ((-1.66666666666666324348e-01 + square * 8.33333333332248946124e-03) +
           fourth * ((-1.98412698298579493134e-04 + square * 2.75573137070700676789e-06) +
                     fourth * (-2.50507602534068634195e-08 + square * 1.58969099521155010221e-10)));
  const Values cosine =
      (1.0 - 0.5 * square) +
      fourth *
          ((4.16666666666666019037e-02 + square * -1.38888888888741095749e-03) +
           fourth * ((2.48015872894767294178e-05 + square * -2.75573143513906633035e-07) +
                     fourth * (2.08757232129817482790e-09 + square * -1.13596475577881948265e-11)));
  for (int i = 0; i < Count; ++i) {
    std::int64_t quarter;
    std::memcpy(&quarter, &shifted[i], sizeof quarter);
    const bool odd = (quarter & 1) != 0;
    const double first = odd ? cosine[i] : sine[i];
    const double second = odd ? sine[i] : cosine[i];
    result.sine[i] = (quarter & 2) != 0 ? -first : first;
    result.cosine[i] = ((quarter + 1) & 2) != 0 ? -second : second;
  }
  return result;
}

}  // namespace ring_gyro
