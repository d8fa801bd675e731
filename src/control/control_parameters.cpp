#include "ring_gyro/control/control_parameters.h"

#include <string>

namespace cvg {
namespace {

void declareTuning(ParameterTable& table, const std::string& loop, LoopTuning& tuning,
                   const std::string& what) {
  table
      .number(loop + "_bandwidth", tuning.bandwidth, "Hz", Range::between(1e-3, 100.0),
              "natural frequency of " + what)
      .number(loop + "_damping", tuning.damping, "1", Range::between(0.3, 3.0),
              "damping ratio of " + what);
}

}  // namespace

void ControlParameters::declare(ParameterTable& table) {
  table
      .number("frequency_offset", frequency_offset, "Hz", Range::between(-1e3, 1e3),
              "start frequency of the NCO minus the natural frequency")
      .number("amplitude", amplitude, "V", Range::between(1e-3, 10.0), "setpoint of a")
      .number("drive_limit", drive_limit, "V", Range::between(1e-3, 1e3),
              "largest drive amplitude of an axis")
      .number("frequency_range", frequency_range, "Hz", Range::between(0.1, 1e4),
              "largest deviation of the NCO from its start frequency")
      .number(
          "virtual_rate", virtual_rate, "rad/s", Range::between(-100.0, 100.0),
          "steering after lock: acts like a rotation k Om of this value; if positive, theta falls")
      .number("hold_delay", hold_delay, "s", Range::between(0.0, 1e-3),
              "delay of the drive, corrected in its phase: half a sample for a zero-order hold")
      .number("hold_gain", hold_gain, "1", Range::between(0.1, 1.0),
              "gain of the drive, corrected in its amplitude: 0.992 for a hold at 200 kHz");
  declareTuning(table, "phase_loop", phase_loop, "the phase-locked loop");
  declareTuning(table, "amplitude_loop", amplitude_loop, "the amplitude loop");
  declareTuning(table, "quadrature_loop", quadrature_loop, "the quadrature loop");
  declareTuning(table, "angle_tracker", angle_tracker, "the tracker of the precession rate");
  table
      .number("learning_rate", learning_rate, "1/s", Range::between(0.0, 10.0),
              "rate at which the loops learn the swing of quadrature and frequency with the "
              "pattern angle; 0: off")
      .number("amplitude_modulation", amplitude_modulation, "1", Range::between(0.0, 0.5),
              "relative swing of the setpoint of a; separates errors of the drive from those of "
              "the ring")
      .number("amplitude_modulation_frequency", amplitude_modulation_frequency, "Hz",
              Range::between(1e-3, 10.0), "frequency of that swing");
  table.flag("compensation", compensation, "apply the decisions of the compensation injector")
      .flag("calibration_run", calibration_run,
            "take steering, amplitude and corrections from a calibration run");
}

}  // namespace cvg
