#include "ring_gyro/resonator/sampled_resonator.h"

#include <cmath>

namespace cvg {

SampledResonator::SampledResonator(const ResonatorParameters& parameters, double gap_cubic,
                                   double sample_period)
    : parameters_(parameters),
      gap_cubic_(gap_cubic),
      drive_gain_(parameters.driveGain()),
      period_(sample_period),
      step_(sample_period / kSubsteps) {}

void SampledResonator::setLinear(const RingResonator& resonator) {
  if (taken_conditions_ == resonator.conditionChanges()) return;
  taken_conditions_ = resonator.conditionChanges();
  // A held drive f moves the ring about its rest position u_f: u -> flow (u - u_f) + u_f.
  Eigen::Matrix<double, 4, 2> rest_per_volt = Eigen::Matrix<double, 4, 2>::Zero();
  rest_per_volt.topRows<2>() = resonator.compliance();
  half_ = resonator.flow(0.5 * step_);
  held_half_ = rest_per_volt - half_ * rest_per_volt;
  whole_ = resonator.flow(period_);
  held_whole_ = rest_per_volt - whole_ * rest_per_volt;
  if (gap_cubic_ != 0.0) setGapNodes(resonator, rest_per_volt);
}

void SampledResonator::setGapNodes(const RingResonator& resonator,
                                   const Eigen::Matrix<double, 4, 2>& rest_per_volt) {
  // Gauss-Legendre, three nodes. They are symmetric, so the flow from the start to one node is also
  // the flow from the opposite node to the end.
  const double spread = 0.5 * std::sqrt(0.6);
  const double nodes[3] = {0.5 - spread, 0.5, 0.5 + spread};
  const double weights[3] = {5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0};
  const double w0 = parameters_.angularFrequency();
  const Eigen::Vector4d balance(1.0, 1.0, 1.0 / w0, 1.0 / w0);
  Eigen::Matrix4d flows[3];
  for (int k = 0; k < 3; ++k) flows[k] = resonator.flow(nodes[k] * period_);
  gap_nodes_ = {};
  for (int k = 0; k < 3; ++k) {
    const Eigen::Matrix<double, 2, 4> seen =
        flows[k].topRows<2>() * balance.cwiseInverse().asDiagonal();
    const Eigen::Matrix2d held = (rest_per_volt - flows[k] * rest_per_volt).topRows<2>();
    const int half = k / 2;
    const int lane = 2 * (k % 2);
    Eigen::Map<Eigen::Matrix4d>(gap_nodes_.flow[half]).middleRows<2>(lane) = seen;
    Eigen::Map<Eigen::Matrix<double, 4, 2>>(gap_nodes_.input[half]).middleRows<2>(lane) = held;
    const Eigen::Matrix<double, 4, 2> kick = (weights[k] * period_ * drive_gain_ * gap_cubic_) *
                                             (balance.asDiagonal() * flows[2 - k].rightCols<2>());
    Eigen::Map<Eigen::Vector4d>(gap_nodes_.kick[2 * k]) = kick.col(0);
    Eigen::Map<Eigen::Vector4d>(gap_nodes_.kick[2 * k + 1]) = kick.col(1);
  }
}

void SampledResonator::moveHeld(Eigen::Vector4d& state, const double* drive_x,
                                const double* drive_y, std::size_t count,
                                const Eigen::Vector2d& delays, double* x, double* y) const {
  // With displacements and velocities / w0, which are of similar size.
  const double w0 = parameters_.angularFrequency();
  const Eigen::Vector4d balance(1.0, 1.0, 1.0 / w0, 1.0 / w0);
  LinearRecurrence recurrence;
  Eigen::Map<Eigen::Matrix4d>(recurrence.flow) =
      balance.asDiagonal() * whole_ * balance.cwiseInverse().asDiagonal();
  Eigen::Map<Eigen::Matrix<double, 4, 2>>(recurrence.input) = balance.asDiagonal() * held_whole_;
  Eigen::Map<Eigen::Vector4d>(recurrence.output) << std::cos(delays[0]), std::cos(delays[1]),
      -std::sin(delays[0]), -std::sin(delays[1]);
  Eigen::Vector4d balanced = balance.asDiagonal() * state;
  if (gap_cubic_ == 0.0) {
    runRecurrence(recurrence, balanced.data(), drive_x, drive_y, count, x, y);
  } else {
    runGapRecurrence(recurrence, gap_nodes_, balanced.data(), drive_x, drive_y, count, x, y);
  }
  state = balance.cwiseInverse().asDiagonal() * balanced;
}

Eigen::Vector4d SampledResonator::rest(const Eigen::Vector4d& state, double extra_rate,
                                       const Eigen::Vector2d& volts) const {
  const double w0 = parameters_.angularFrequency();
  const double stiffening = -w0 * w0 * parameters_.cubic_stiffness * state.head<2>().squaredNorm();
  const double coriolis = 2.0 * parameters_.angular_gain * extra_rate;
  const double gap = drive_gain_ * gap_cubic_;
  return {0.0, 0.0,
          stiffening * state[0] + coriolis * state[3] + gap * volts[0] * state[0] * state[0],
          stiffening * state[1] - coriolis * state[2] + gap * volts[1] * state[1] * state[1]};
}

Eigen::Vector4d SampledResonator::step(const Eigen::Vector4d& state, const SampleDrive& drive,
                                       double time,
                                       const std::function<double(double)>& extra_rate) const {
  static_assert(kSubsteps == 2);
  const double middle = 0.5 * (drive.phase + drive.next_phase);
  const Eigen::Vector4d halfway = substep(state, drive, drive.phase, middle, time, extra_rate);
  return substep(halfway, drive, middle, drive.next_phase, time + step_, extra_rate);
}

Eigen::Vector4d SampledResonator::substep(const Eigen::Vector4d& state, const SampleDrive& drive,
                                          double phase, double next_phase, double time,
                                          const std::function<double(double)>& extra_rate) const {
  const double h = step_;
  const double rate_begin = extra_rate(time);
  const double rate_middle = extra_rate(time + 0.5 * h);
  const double rate_end = extra_rate(time + h);
  Eigen::Vector4d middle;
  Eigen::Vector4d end;
  Eigen::Vector2d volts_begin = drive.value;
  Eigen::Vector2d volts_middle = drive.value;
  Eigen::Vector2d volts_end = drive.value;
  if (drive.held) {
    const Eigen::Vector4d held = held_half_ * drive.value;
    middle = half_ * state + held;
    end = half_ * middle + held;
  } else {
    const double middle_phase = 0.5 * (phase + next_phase);
    const Eigen::Vector4d forced_middle = drive.forced.at(middle_phase);
    middle = half_ * (state - drive.forced.at(phase)) + forced_middle;
    end = half_ * (middle - forced_middle) + drive.forced.at(next_phase);
    if (gap_cubic_ != 0.0) {
      volts_begin = drive.force.at(phase);
      volts_middle = drive.force.at(middle_phase);
      volts_end = drive.force.at(next_phase);
    }
  }

  const Eigen::Vector4d k1 = half_ * rest(state, rate_begin, volts_begin);
  const Eigen::Vector4d k2 = rest(middle + 0.5 * h * k1, rate_middle, volts_middle);
  const Eigen::Vector4d k3 = rest(middle + 0.5 * h * k2, rate_middle, volts_middle);
  const Eigen::Vector4d k4 = rest(end + h * (half_ * k3), rate_end, volts_end);
  return end + (h / 6.0) * (half_ * (k1 + 2.0 * (k2 + k3)) + k4);
}

}  // namespace cvg
