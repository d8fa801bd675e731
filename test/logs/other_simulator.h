#pragma once

#include <array>
#include <boost/numeric/odeint.hpp>
#include <cmath>
#include <complex>
#include <cstdio>
#include <random>
#include <stdexcept>
#include <string>

namespace other_lab {

/// The device of another lab, in its own words.
struct Device {
  double f0 = 14e3;  // Hz
  double q = 22000.0;
  double gamma1 = 0.02;
  double gamma2 = 0.03;
  double mu1 = -30e-6;
  double mu2 = -40e-6;
  double ks = 1.1e5;  // 1/s^2
};

/// A gyroscope simulated by somebody else, who shares no code with this package: the two equations
/// of motion by Runge-Kutta-Fehlberg 7(8), a lock-in with three RC stages, energy, quadrature and
/// phase invariants, PI loops at 500 Hz without any prediction, a reference whose lock is at 0 deg,
/// an assumed drive gain that is 9 % off, a quadrature gain of opposite sign and an angle folded
/// into half a turn.
class Simulator {
 public:
  static constexpr double kLoopPeriod = 2e-3;  // s
  static constexpr double kAssumedKs = 1.0e5;  // 1/s^2
  static constexpr double kSteering = 12.0;    // deg/s
  static constexpr double kNoise = 1e-4;       // V, of each quadrature in a reading

  explicit Simulator(const Device& device)
      : d_(device), w0_(kTurn * device.f0), w_(kTurn * (device.f0 + 0.2)) {
    steps_ = static_cast<int>(std::lround(kLoopPeriod * d_.f0 * 14.0));
    h_ = kLoopPeriod / steps_;
    share_ = 1.0 - std::exp(-h_ / kStage);
    // It vibrates already: x = sin psi.
    state_ = {0.0, 0.0, w_, 0.0};
    for (auto& stage : x_) stage = {0.0, -1.0};
  }

  /// From a reading back to where it is valid [s].
  double groupDelay() const { return 3.0 * h_ * (1.0 - share_) / share_; }

  void writeLog(const std::string& path, double seconds) {
    std::FILE* const file = std::fopen(path.c_str(), "wb");
    if (!file) throw std::runtime_error("cannot write " + path);
    std::fputs(
        "\xEF\xBB\xBF"
        "Time [ms];Angle [deg];Amplitude [mV];Quad [mV];Phase [deg];PLL frequency [Hz];"
        "Sustain gain [us];Quad gain [mV/V];Steering rate [deg/s]\r\n",
        file);
    const long rows = std::lround(seconds / kLoopPeriod);
    for (long row = 1; row <= rows; ++row) {
      integrate();
      control();
      char text[400];
      std::snprintf(text, sizeof text, "%.3f;%.10f;%.10f;%.10f;%.10f;%.10f;%.12f;%.12f;%.3f\r\n",
                    1e3 * kLoopPeriod * static_cast<double>(row), degrees(angle_), 1e3 * a_,
                    1e3 * b_, degrees(phase_), w_ / kTurn, 1e6 * beta_, -1e3 * alpha_, kSteering);
      for (char* c = text; *c != '\0'; ++c) {
        if (*c == '.') *c = ',';
      }
      std::fputs(text, file);
    }
    if (std::fclose(file) != 0) throw std::runtime_error("cannot write " + path);
  }

 private:
  using Complex = std::complex<double>;
  using State = std::array<double, 4>;  // x, y, x', y'

  static constexpr double kTurn = 6.283185307179586476925;
  static constexpr double kStage = 0.4e-3;  // s, of an RC stage

  static double degrees(double radians) { return 360.0 / kTurn * radians; }

  void integrate() {
    const double damping = w0_ / d_.q;
    double psi0 = 0.0;
    const auto equations = [&](const State& s, State& ds, double t) {
      const double c = std::cos(psi0 + w_ * t);
      const double q = std::sin(psi0 + w_ * t);
      const double fx = fx_.real() * c - fx_.imag() * q;
      const double fy = fy_.real() * c - fy_.imag() * q;
      ds[0] = s[2];
      ds[1] = s[3];
      ds[2] = d_.ks * fx - damping * ((1.0 + d_.gamma1) * s[2] + d_.gamma2 * s[3]) -
              w0_ * w0_ * ((1.0 + d_.mu1) * s[0] + d_.mu2 * s[1]);
      ds[3] = d_.ks * fy - damping * (d_.gamma2 * s[2] + (1.0 - d_.gamma1) * s[3]) -
              w0_ * w0_ * (d_.mu2 * s[0] + (1.0 - d_.mu1) * s[1]);
    };
    for (int k = 0; k < steps_; ++k) {
      psi0 = psi_;
      stepper_.do_step(equations, state_, 0.0, h_);
      psi_ = std::fmod(psi_ + w_ * h_, kTurn);
      const Complex back = 2.0 * std::polar(1.0, -psi_);
      Complex x = state_[0] * back;
      Complex y = state_[1] * back;
      for (int stage = 0; stage < 3; ++stage) {
        x = x_[stage] += share_ * (x - x_[stage]);
        y = y_[stage] += share_ * (y - y_[stage]);
      }
    }
  }

  void control() {
    const auto noise = [this] {
      return Complex(kNoise * normal_(random_), kNoise * normal_(random_));
    };
    const Complex x = x_[2] + noise();
    const Complex y = y_[2] + noise();
    // Lynch's invariants.
    const double energy = std::norm(x) + std::norm(y);
    const double quadrature = 2.0 * (x * std::conj(y)).imag();
    const double r = std::norm(x) - std::norm(y);
    const double s = 2.0 * (x * std::conj(y)).real();
    const double spread = std::sqrt(energy * energy - quadrature * quadrature);
    a_ = std::sqrt(0.5 * (energy + spread));
    b_ = 0.5 * quadrature / a_;
    angle_ = 0.5 * std::atan2(s, r);
    // The lab's reference leads by a quarter turn, so that the locked phase is zero.
    phase_ = 0.5 * std::arg(-(x * x + y * y));
    // On which end of the axis it is when the drive is positive.
    const Complex along = x * std::cos(angle_) + y * std::sin(angle_);
    const double end = (Complex(0.0, 1.0) * along).real() > 0.0 ? 1.0 : -1.0;
    const double c = end * std::cos(angle_);
    const double q = end * std::sin(angle_);

    const double natural = kTurn * 12.0;  // rad/s, of the loops
    phase_sum_ += natural * natural * phase_ * kLoopPeriod;
    w_ = kTurn * (d_.f0 + 0.2) + 2.0 * natural * phase_ + phase_sum_;
    energy_sum_ += natural * natural * (1.0 - a_) * kLoopPeriod;
    quad_sum_ += natural * natural * b_ * kLoopPeriod;
    const double volts = 2.0 * w_ / kAssumedKs;  // per V/s
    beta_ = volts * (2.0 * natural * (1.0 - a_) + energy_sum_) / (w_ * a_);
    alpha_ = volts * (2.0 * natural * b_ + quad_sum_) / a_;
    // Force along the axis and across it, by velocity (a, -ib) w and displacement over i.
    const double steer = 2.0 * kTurn / 360.0 * kSteering / kAssumedKs;
    const Complex va(w_ * a_, 0.0);
    const Complex vb(0.0, -w_ * b_);
    const Complex i_w(0.0, w_);
    const Complex f1 = beta_ * va + alpha_ * vb / i_w + steer * vb;
    const Complex f2 = beta_ * vb - alpha_ * va / i_w - steer * va;
    fx_ = c * f1 - q * f2;
    fy_ = q * f1 + c * f2;
  }

  Device d_;
  double w0_;
  double w_;
  int steps_;
  double h_;
  double share_;
  State state_;
  double psi_ = 0.0;
  std::array<Complex, 3> x_{};
  std::array<Complex, 3> y_{};
  Complex fx_;
  Complex fy_;
  double a_ = 0.0, b_ = 0.0, angle_ = 0.0, phase_ = 0.0, beta_ = 0.0, alpha_ = 0.0;
  double phase_sum_ = 0.0, energy_sum_ = 0.0, quad_sum_ = 0.0;
  boost::numeric::odeint::runge_kutta_fehlberg78<State> stepper_;
  std::mt19937_64 random_{7};
  std::normal_distribution<double> normal_;
};

}  // namespace other_lab
