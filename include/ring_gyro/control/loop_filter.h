#pragma once

namespace cvg {

/// Gains of a proportional-integral controller around an integrator with gain 1.
struct LoopGains {
  double proportional = 0.0;  ///< [1/s]
  double integral = 0.0;      ///< [1/s^2]
};

/// Gains that give the loop s^2 + 2 zeta wn s + wn^2: `bandwidth` = wn / 2 pi [Hz], `damping` =
/// zeta; `decay` is the plant's own decay rate [1/s].
LoopGains loopGains(double bandwidth, double damping, double decay = 0.0);

/// Proportional-integral controller with output limits. At a limit the integral does not grow
/// further beyond the limit (anti-windup).
class LoopFilter {
 public:
  /// Limits in the unit of the output, lowest < highest; period of the updates [s].
  LoopFilter(LoopGains gains, double period, double lowest, double highest);

  /// Output for this error. The limits apply to the sum of the output and `beside`, which the
  /// caller adds to it.
  double update(double error, double beside = 0.0);
  void reset(double integral = 0.0) { integral_ = integral; }
  double integral() const { return integral_; }

 private:
  LoopGains gains_;
  double period_;
  double lowest_;
  double highest_;
  double integral_ = 0.0;
};

}  // namespace cvg
