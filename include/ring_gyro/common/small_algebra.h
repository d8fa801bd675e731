#pragma once

#include <Eigen/Core>
#include <complex>
#include <cstdint>

#include "ring_gyro/common/lanes.h"

namespace cvg {

// The algebra of the identifier's filter: two axes, five parameters, and phasors. Eigen is easier
// to read, but it writes the two numbers of a vector one by one and then loads them as one
// register, which makes the processor wait as long as for a division. Here they stay in registers.

/// Two numbers, such as a and b. Sums and products are element by element.
using Vector2 = TwoLanes;

inline Vector2 vector2(const Eigen::Vector2d& vector) { return Vector2{vector[0], vector[1]}; }
inline Eigen::Vector2d eigen(const Vector2& vector) { return {vector[0], vector[1]}; }

/// Absolute value of each number.
inline Vector2 magnitude(const Vector2& vector) {
  using Whole = WholeLanes<Vector2>::Type;
  const Whole sign = Whole{} + (std::uint64_t{1} << 63);
  return (Vector2)((Whole)vector & ~sign);
}
inline Vector2 swapped(const Vector2& vector) { return Vector2{vector[1], vector[0]}; }

/// A 2x2 matrix by columns.
struct Matrix2 {
  Vector2 first = {};
  Vector2 second = {};

  static Matrix2 diagonal(double first, double second) {
    return {Vector2{first, 0.0}, Vector2{0.0, second}};
  }
};

inline Eigen::Matrix2d eigen(const Matrix2& matrix) {
  Eigen::Matrix2d result;
  result << eigen(matrix.first), eigen(matrix.second);
  return result;
}

inline Matrix2 operator+(const Matrix2& one, const Matrix2& other) {
  return {one.first + other.first, one.second + other.second};
}
inline Matrix2 operator-(const Matrix2& one, const Matrix2& other) {
  return {one.first - other.first, one.second - other.second};
}
/// A number added to a matrix means that number times the identity.
inline Matrix2 operator+(const Matrix2& matrix, double number) {
  return matrix + Matrix2::diagonal(number, number);
}
inline Matrix2 operator-(const Matrix2& matrix, double number) {
  return matrix - Matrix2::diagonal(number, number);
}
inline Matrix2 operator*(double factor, const Matrix2& matrix) {
  return {factor * matrix.first, factor * matrix.second};
}
inline Vector2 operator*(const Matrix2& matrix, const Vector2& vector) {
  return matrix.first * vector[0] + matrix.second * vector[1];
}
inline Matrix2 operator*(const Matrix2& one, const Matrix2& other) {
  return {one * other.first, one * other.second};
}
inline Matrix2 transposed(const Matrix2& matrix) {
  return {Vector2{matrix.first[0], matrix.second[0]}, Vector2{matrix.first[1], matrix.second[1]}};
}
inline double determinant(const Matrix2& matrix) {
  return matrix.first[0] * matrix.second[1] - matrix.second[0] * matrix.first[1];
}
/// The determinant must not be zero.
inline Matrix2 inverse(const Matrix2& matrix) {
  const double scale = 1.0 / determinant(matrix);
  return {scale * Vector2{matrix.second[1], -matrix.first[1]},
          scale * Vector2{-matrix.second[0], matrix.first[0]}};
}
/// column row'.
inline Matrix2 outer(const Vector2& column, const Vector2& row) {
  return {column * row[0], column * row[1]};
}
/// (matrix + matrix') / 2: a symmetric matrix without the asymmetry that rounding has added.
inline Matrix2 symmetric(const Matrix2& matrix) {
  const double off = 0.5 * (matrix.first[1] + matrix.second[0]);
  return {Vector2{matrix.first[0], off}, Vector2{off, matrix.second[1]}};
}

/// Five numbers, one for each device parameter: gamma1, gamma2, mu1, mu2 and ks.
struct Vector5 {
  FourLanes mismatch = {};  ///< gamma1, gamma2, mu1, mu2
  double drive_gain = 0.0;  ///< ks

  Vector5() = default;
  Vector5(const FourLanes& of_mismatch, double of_drive_gain)
      : mismatch(of_mismatch), drive_gain(of_drive_gain) {}
  explicit Vector5(const Eigen::Matrix<double, 5, 1>& vector) : drive_gain(vector[4]) {
    load(vector.data(), mismatch);
  }
};

inline Eigen::Matrix<double, 5, 1> eigen(const Vector5& vector) {
  Eigen::Matrix<double, 5, 1> result;
  store(vector.mismatch, result.data());
  result[4] = vector.drive_gain;
  return result;
}

inline Vector5 operator+(const Vector5& one, const Vector5& other) {
  return {one.mismatch + other.mismatch, one.drive_gain + other.drive_gain};
}
inline Vector5 operator-(const Vector5& one, const Vector5& other) {
  return {one.mismatch - other.mismatch, one.drive_gain - other.drive_gain};
}
inline Vector5 operator*(double factor, const Vector5& vector) {
  return {factor * vector.mismatch, factor * vector.drive_gain};
}
inline double sumOf(const Vector5& vector) { return sumOf(vector.mismatch) + vector.drive_gain; }
inline double dot(const Vector5& one, const Vector5& other) {
  return sumOf(Vector5(one.mismatch * other.mismatch, one.drive_gain * other.drive_gain));
}

/// How two quantities, such as a and b, depend on the five parameters: a 2x5 matrix by rows.
struct Matrix2x5 {
  Vector5 first;
  Vector5 second;
};

inline Eigen::Matrix<double, 2, 5> eigen(const Matrix2x5& matrix) {
  Eigen::Matrix<double, 2, 5> result;
  result << eigen(matrix.first).transpose(), eigen(matrix.second).transpose();
  return result;
}

inline Matrix2x5 operator+(const Matrix2x5& one, const Matrix2x5& other) {
  return {one.first + other.first, one.second + other.second};
}
inline Matrix2x5 operator-(const Matrix2x5& one, const Matrix2x5& other) {
  return {one.first - other.first, one.second - other.second};
}
inline Matrix2x5 operator*(double factor, const Matrix2x5& matrix) {
  return {factor * matrix.first, factor * matrix.second};
}
inline Matrix2x5 operator*(const Matrix2& left, const Matrix2x5& right) {
  return {left.first[0] * right.first + left.second[0] * right.second,
          left.first[1] * right.first + left.second[1] * right.second};
}
inline Vector2 operator*(const Matrix2x5& matrix, const Vector5& vector) {
  return Vector2{dot(matrix.first, vector), dot(matrix.second, vector)};
}

/// A complex number. `Real`: double, or Lanes for several side by side. std::complex tests each
/// product for infinities, and cannot have lanes.
template <typename Real>
struct Phasor {
  Real re = {};
  Real im = {};
};

inline Phasor<double> phasor(const std::complex<double>& number) {
  return {number.real(), number.imag()};
}

template <typename Real>
inline Phasor<Real> operator+(const Phasor<Real>& one, const Phasor<Real>& other) {
  return {one.re + other.re, one.im + other.im};
}
template <typename Real>
inline Phasor<Real> operator-(const Phasor<Real>& one, const Phasor<Real>& other) {
  return {one.re - other.re, one.im - other.im};
}
template <typename Real>
inline Phasor<Real> operator*(const Real& factor, const Phasor<Real>& phasor) {
  return {factor * phasor.re, factor * phasor.im};
}
template <typename Real>
inline Phasor<Real> operator*(const Phasor<Real>& one, const Phasor<Real>& other) {
  return {one.re * other.re - one.im * other.im, one.re * other.im + one.im * other.re};
}
template <typename Real>
inline Phasor<Real> conjugate(const Phasor<Real>& phasor) {
  return {phasor.re, -phasor.im};
}
template <typename Real>
inline Phasor<Real> timesI(const Phasor<Real>& phasor) {
  return {-phasor.im, phasor.re};
}

}  // namespace cvg
