#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "ring_gyro/analysis/rate_harmonics.h"
#include "ring_gyro/calibration/calibration_parameters.h"
#include "ring_gyro/calibration/calibration_result.h"
#include "ring_gyro/common/converter_parameters.h"
#include "ring_gyro/common/device_knowledge.h"
#include "ring_gyro/identification/filter/extended_identifier.h"
#include "ring_gyro/signals/calibration_command.h"
#include "ring_gyro/signals/control_gains.h"
#include "ring_gyro/signals/orbital_elements.h"

namespace cvg {

/// The experiment that calibrates a gyroscope automatically. Input: blocks. Output: settings of the
/// loops.
///
/// Stage one, steering (a virtual rate): survey the drift and choose the rate; identify ring and
/// drive path with the amplitude modulated, at both signs of the rate, correct, identify again;
/// measure the drift against the angle at both signs, cancel its even part by steering, and repeat.
/// Stage two, on a rate table: measure the angle map at both signs of a true rotation. Then judge
/// the result at rates that were not used before. Without a table the map of a linear pick-off
/// error stays unknown and none is applied (docs/calibration.md).
///
/// One command per period, which acts one period after the data that it was computed from, so that
/// thread scheduling cannot change a run.
class CalibrationProcedure {
 public:
  /// `device`: nominal values in the loops. `initial`: corrections that already act.
  /// `period_blocks`: blocks between commands. Throws std::invalid_argument, naming a parameter
  /// that cannot be used.
  CalibrationProcedure(const DeviceKnowledge& device, const CalibrationRunParameters& parameters,
                       const ExtendedParameters& identification,
                       const ConverterParameters& converter, std::int64_t period_blocks,
                       const Corrections& initial);

  /// The next block; gives a command at the end of each period.
  std::optional<CalibrationCommand> process(const OrbitalElements& elements,
                                            const ControlGains& gains);

  /// Complete after a command with `finished`. Until then it contains the results so far and names
  /// the missing stages; from the first identification on it is a usable calibration.
  const CalibrationResult& result() const { return result_; }

 private:
  enum class Stage {
    kSurvey,
    kIdentification,
    kDrift,
    kTable,
    kVerification,
    kToWorstAngle,
    kThreshold
  };
  struct Leg {
    Stage stage = Stage::kSurvey;
    std::string name;
    std::string result;  // the result that the leg is for, for display
    double virtual_rate = 0.0;
    double table_rate = 0.0;
    double settling = 0.0;    // [s]
    double duration = 0.0;    // after the settling [s]
    double least_turn = 0.0;  // least turn of the pattern after the settling [rad]
    bool second_of_pair = false;
  };

  void plan(double steering_rate);
  void planPair(Stage stage, const std::string& name, double virtual_rate, double table_rate,
                double duration);
  void sizeLegs();
  void record(const OrbitalElements& elements, const ControlGains& gains);
  double patternRate(const Leg& leg) const;
  double turned() const;
  bool legOver() const;
  void finishLeg();
  void finishSurvey();
  void finishIdentification();
  void finishDriftRound(const RateHarmonics& forward, const RateHarmonics& backward);
  void poolDriftRounds();
  void finishTable(const RateHarmonics& forward, const RateHarmonics& backward);
  void finishVerification(const RateHarmonics& forward, const RateHarmonics& backward);
  void aimAtWorstAngle();
  void finishThreshold();
  double identified(const std::string& name) const;
  Corrections correctionsForDevice() const;
  LoopSettings settings() const;
  double timeLeft() const;
  std::vector<std::string> missingStages() const;

  DeviceKnowledge device_;
  CalibrationRunParameters parameters_;
  ExtendedParameters identification_;
  ConverterParameters converter_;
  std::uint64_t period_blocks_;
  std::optional<ExtendedIdentifier> identifier_;
  std::optional<ExtendedEstimate> estimate_;

  std::deque<Leg> legs_;             // the front is the present leg
  std::uint64_t leg_begin_ = 0;      // block from which its settings act
  double settled_time_ = 0.0;        // usable time since then [s]
  double unusable_time_ = 0.0;       // since the last usable block [s]
  std::vector<AngleSample> theta_;   // pattern angle in the leg, settled
  std::vector<AngleSample> output_;  // output angle in the leg, settled
  bool passed_worst_angle_ = false;
  std::optional<RateHarmonics> forward_;  // of the first leg of a pair
  Corrections corrections_;               // that act, with the gains that the loops have
  std::string failure_;
  bool finished_ = false;
  CalibrationResult result_;
};

}  // namespace cvg
