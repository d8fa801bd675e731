#pragma once

#include <cstdint>

#include "ring_gyro/common/lanes.h"

namespace cvg {

// Algebra of two numbers, such as what belongs to a and b, in one register. Eigen writes them one
// by one and reads them as two, for which a processor waits as long as for a division.

/// Of each of the two numbers.
inline TwoLanes magnitude(const TwoLanes& pair) {
  using Whole = WholeLanes<TwoLanes>::Type;
  const Whole sign = Whole{} + (std::uint64_t{1} << 63);
  return (TwoLanes)((Whole)pair & ~sign);
}

/// A 2x2 matrix by columns.
struct Square {
  TwoLanes first = {};
  TwoLanes second = {};
};

inline Square operator+(const Square& one, const Square& other) {
  return {one.first + other.first, one.second + other.second};
}
inline Square operator-(const Square& one, const Square& other) {
  return {one.first - other.first, one.second - other.second};
}
inline Square operator*(double factor, const Square& matrix) {
  return {factor * matrix.first, factor * matrix.second};
}
inline TwoLanes operator*(const Square& matrix, const TwoLanes& pair) {
  return matrix.first * pair[0] + matrix.second * pair[1];
}
inline Square operator*(const Square& one, const Square& other) {
  return {one * other.first, one * other.second};
}
inline Square transposed(const Square& matrix) {
  return {TwoLanes{matrix.first[0], matrix.second[0]}, TwoLanes{matrix.first[1], matrix.second[1]}};
}
inline Square diagonal(double first, double second) {
  return {TwoLanes{first, 0.0}, TwoLanes{0.0, second}};
}
inline double determinant(const Square& matrix) {
  return matrix.first[0] * matrix.second[1] - matrix.second[0] * matrix.first[1];
}
inline Square inverse(const Square& matrix) {
  const double scale = 1.0 / determinant(matrix);
  return {scale * TwoLanes{matrix.second[1], -matrix.first[1]},
          scale * TwoLanes{-matrix.second[0], matrix.first[0]}};
}
/// column row'.
inline Square outer(const TwoLanes& column, const TwoLanes& row) {
  return {column * row[0], column * row[1]};
}
/// (matrix + matrix') / 2: without what rounding has made of a symmetric one.
inline Square symmetric(const Square& matrix) {
  const double off = 0.5 * (matrix.first[1] + matrix.second[0]);
  return {TwoLanes{matrix.first[0], off}, TwoLanes{off, matrix.second[1]}};
}

}  // namespace cvg
