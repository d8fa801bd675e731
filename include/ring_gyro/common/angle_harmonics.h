#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

namespace cvg {

/// A periodic function of the pattern angle,
/// constant + sum over n of [cosine_n cos(n theta) + sine_n sin(n theta)].
struct AngleHarmonics {
  double constant = 0.0;
  std::vector<double> cosine;  ///< of n theta at index n - 1, in the unit of the function
  std::vector<double> sine;    ///< of n theta at index n - 1; may be longer or shorter than cosine

  double at(double theta) const {
    return constant + sum(theta, [](double cos_part, double sin_part, double cos_n, double sin_n,
                                    double) { return cos_part * cos_n + sin_part * sin_n; });
  }

  /// Derivative with respect to theta [unit of the function / rad].
  double slopeAt(double theta) const {
    return sum(theta, [](double cos_part, double sin_part, double cos_n, double sin_n, double n) {
      return n * (sin_part * cos_n - cos_part * sin_n);
    });
  }

  std::size_t orders() const { return cosine.size() > sine.size() ? cosine.size() : sine.size(); }

  AngleHarmonics& operator*=(double factor) {
    constant *= factor;
    for (double& value : cosine) value *= factor;
    for (double& value : sine) value *= factor;
    return *this;
  }

  AngleHarmonics& operator+=(const AngleHarmonics& other) {
    constant += other.constant;
    add(cosine, other.cosine);
    add(sine, other.sine);
    return *this;
  }

 private:
  template <typename Term>
  double sum(double theta, const Term& term) const {
    const double cos_1 = std::cos(theta);
    const double sin_1 = std::sin(theta);
    double cos_n = 1.0;
    double sin_n = 0.0;
    double total = 0.0;
    for (std::size_t i = 0; i < orders(); ++i) {
      const double next = cos_n * cos_1 - sin_n * sin_1;
      sin_n = sin_n * cos_1 + cos_n * sin_1;
      cos_n = next;
      total += term(i < cosine.size() ? cosine[i] : 0.0, i < sine.size() ? sine[i] : 0.0, cos_n,
                    sin_n, static_cast<double>(i + 1));
    }
    return total;
  }

  static void add(std::vector<double>& to, const std::vector<double>& from) {
    if (to.size() < from.size()) to.resize(from.size(), 0.0);
    for (std::size_t i = 0; i < from.size(); ++i) to[i] += from[i];
  }
};

inline AngleHarmonics scaled(AngleHarmonics function, double factor) { return function *= factor; }

}  // namespace cvg
