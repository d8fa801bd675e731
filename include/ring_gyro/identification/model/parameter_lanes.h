#pragma once

#include "ring_gyro/common/lanes.h"
#include "ring_gyro/common/pairs.h"
#include "ring_gyro/signals/parameter_vector.h"

namespace cvg {

/// A number for each device parameter, in the order of (29): gamma1, gamma2, mu1, mu2 side by side,
/// and ks.
struct ParameterLanes {
  FourLanes mismatch = {};
  double drive_gain = 0.0;

  ParameterLanes() = default;
  ParameterLanes(const FourLanes& of_mismatch, double of_drive_gain)
      : mismatch(of_mismatch), drive_gain(of_drive_gain) {}
  explicit ParameterLanes(const ParameterVector& vector) : drive_gain(vector[4]) {
    load(vector.data(), mismatch);
  }
  ParameterVector vector() const {
    ParameterVector result;
    store(mismatch, result.data());
    result[4] = drive_gain;
    return result;
  }
};

inline ParameterLanes operator+(const ParameterLanes& one, const ParameterLanes& other) {
  return {one.mismatch + other.mismatch, one.drive_gain + other.drive_gain};
}
inline ParameterLanes operator-(const ParameterLanes& one, const ParameterLanes& other) {
  return {one.mismatch - other.mismatch, one.drive_gain - other.drive_gain};
}
/// Element by element.
inline ParameterLanes operator*(const ParameterLanes& one, const ParameterLanes& other) {
  return {one.mismatch * other.mismatch, one.drive_gain * other.drive_gain};
}
inline ParameterLanes operator*(double factor, const ParameterLanes& lanes) {
  return {factor * lanes.mismatch, factor * lanes.drive_gain};
}
inline double sumOf(const ParameterLanes& lanes) {
  return sumOf(lanes.mismatch) + lanes.drive_gain;
}

/// How two quantities, such as a and b, depend on the parameters: a row each.
struct ParameterRows {
  ParameterLanes first;
  ParameterLanes second;

  Eigen::Matrix<double, 2, 5> matrix() const {
    Eigen::Matrix<double, 2, 5> result;
    result << first.vector().transpose(), second.vector().transpose();
    return result;
  }
};

inline ParameterRows operator+(const ParameterRows& one, const ParameterRows& other) {
  return {one.first + other.first, one.second + other.second};
}
inline ParameterRows operator-(const ParameterRows& one, const ParameterRows& other) {
  return {one.first - other.first, one.second - other.second};
}
inline ParameterRows operator*(double factor, const ParameterRows& rows) {
  return {factor * rows.first, factor * rows.second};
}
inline ParameterRows operator*(const Square& matrix, const ParameterRows& rows) {
  return {matrix.first[0] * rows.first + matrix.second[0] * rows.second,
          matrix.first[1] * rows.first + matrix.second[1] * rows.second};
}
/// Of the two quantities, for parameters of these sizes.
inline TwoLanes product(const ParameterRows& rows, const ParameterLanes& parameters) {
  return TwoLanes{sumOf(rows.first * parameters), sumOf(rows.second * parameters)};
}

}  // namespace cvg
