#include "ring_gyro/resonator/electronics_parameters.h"

#include <cmath>

namespace cvg {

Eigen::Matrix2d AxisErrors::alignmentMatrix() const {
  Eigen::Matrix2d alignment;
  alignment << 1.0, 0.0, std::sin(misalignment), std::cos(misalignment);
  return alignment;
}

Eigen::Matrix2d AxisErrors::gainMatrix() const {
  return Eigen::Vector2d(gain_x, gain_y).asDiagonal() * alignmentMatrix();
}

Eigen::Vector2d AxisErrors::phaseDelays() const {
  return {phase_delay, phase_delay + phase_difference};
}

void AxisErrors::declare(ParameterTable& table) {
  table.number("gain_x", gain_x, "1", Range::between(0.1, 10.0), "gain of axis x")
      .number("gain_y", gain_y, "1", Range::between(0.1, 10.0), "gain of axis y")
      .number("misalignment", misalignment, "rad", Range::between(-0.5, 0.5),
              "angle by which electrode y is turned towards x")
      .number("phase_delay", phase_delay, "rad", Range::between(-1.5, 1.5),
              "of both axes, at the resonance")
      .number("phase_difference", phase_difference, "rad", Range::between(-1.5, 1.5),
              "delay of y minus delay of x");
}

void SenseParameters::declare(ParameterTable& table) {
  axes.declare(table);
  table
      .number("noise_density", noise_density, "V/sqrt(Hz)", Range::atLeast(0.0),
              "white noise of each pick-off, one-sided")
      .number("cubic", cubic, "1/V^2", Range::between(-0.3, 0.3),
              "capacitive gap: an electrode displaced by x reads x (1 + cubic x^2)")
      .number("feedthrough", feedthrough, "1", Range::between(-1.0, 1.0),
              "volt in the pick-off per volt of the drive")
      .integer("adc_bits", adc_bits, Range::between(0, 32), "0: ideal converter")
      .number("adc_range", adc_range, "V", Range::above(0.0), "saturates at plus and minus this");
}

void DriveParameters::declare(ParameterTable& table) {
  axes.declare(table);
  table
      .number("noise_density", noise_density, "V/sqrt(Hz)", Range::atLeast(0.0),
              "white noise of each drive, one-sided")
      .number("cubic", cubic, "1/V^2", Range::between(-0.01, 0.01),
              "a drive f acts as f (1 + cubic f^2)")
      .number("bias_voltage", bias_voltage, "V", Range::atLeast(0.0),
              "DC bias of the drive electrodes, whose square law makes a drive f act as f + f^2 / "
              "(2 bias_voltage); 0: linear")
      .number("gap_cubic", gap_cubic, "1/V^2", Range::between(-0.3, 0.3),
              "gap that closes: at displacement x a drive f acts as f (1 + gap_cubic x^2)")
      .flag("zero_order_hold", zero_order_hold,
            "hold each converter sample (delays by half a sample) instead of an ideal modulator")
      .integer("dac_bits", dac_bits, Range::between(0, 32),
               "0: ideal converter; otherwise needs zero_order_hold")
      .number("dac_range", dac_range, "V", Range::above(0.0), "saturates at plus and minus this");
}

}  // namespace cvg
