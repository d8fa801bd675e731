#include "ring_gyro/calibration/calibration_parameters.h"

namespace cvg {

void CalibrationRunParameters::declare(ParameterTable& table) {
  table
      .number("survey_rate", survey_rate, "rad/s", Range::between(0.0, 100.0),
              "steering in the survey; 0: 0.3 xi0 w0, enough for a gamma of 0.1")
      .number("rate_margin", rate_margin, "1", Range::between(1.5, 100.0),
              "steering rate during identification, divided by the drift that the survey found")
      .number("least_rate", least_rate, "rad/s", Range::between(1e-4, 100.0),
              "smallest steering rate during identification, even if that drift is smaller")
      .number("settling_decays", settling_decays, "1", Range::between(1.0, 1000.0),
              "settling before each leg, in times 1/(xi0 w0); never under 2 s")
      .number("identification_time", identification_time, "s", Range::between(1.0, 1e6),
              "time of identification at each sign of the rate")
      .integer("identification_rounds", identification_rounds, Range::between(1.0, 10.0),
               "identify, correct, identify again")
      .number("amplitude_modulation", amplitude_modulation, "1", Range::between(0.0, 0.5),
              "relative swing of the setpoint of a during identification")
      .number("amplitude_modulation_frequency", amplitude_modulation_frequency, "Hz",
              Range::between(1e-3, 10.0), "frequency of that swing")
      .number(
          "drift_time", drift_time, "s", Range::between(1.0, 1e6),
          "time at each sign of the rate in a drift round, but at least 2.2 turns of the pattern")
      .number("last_drift_time", last_drift_time, "s", Range::between(1.0, 1e6),
              "the same in the last round, whose noise stays in the result")
      .integer("drift_rounds", drift_rounds, Range::between(1.0, 10.0),
               "measure drift at both signs, cancel it, measure again")
      .number("drift_rate", drift_rate, "rad/s", Range::between(1e-4, 100.0),
              "steering rate in the drift rounds, in which gamma is cancelled")
      .integer("highest_order", highest_order, Range::between(2.0, 8.0),
               "highest order of drift and angle map in the pattern angle; odd orders are zero")
      .flag("rate_table", rate_table,
            "the case can be turned: measure the angle map, verify with true rotation")
      .number("table_rate", table_rate, "rad/s", Range::between(1e-3, 100.0),
              "rate of the case while the angle map is measured")
      .number("table_time", table_time, "s", Range::between(1.0, 1e6),
              "time of that at each sign, but at least 2.2 turns of the pattern")
      .numbers("verification_rates", verification_rates, "rad/s", Range::between(1e-3, 100.0),
               "rates of the case at which the calibrated gyroscope is judged; without a rate "
               "table, of steering")
      .number("verification_time", verification_time, "s", Range::between(1.0, 1e6),
              "time at each of these rates and each sign, but at least 2.2 turns of the pattern")
      .number("threshold_time", threshold_time, "s", Range::between(1.0, 1e6),
              "time of turning at twice the rate threshold");
}

}  // namespace cvg
