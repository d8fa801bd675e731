#pragma once

#include <cstdint>
#include <optional>

#include "ring_gyro/calibration/calibration_procedure.h"
#include "ring_gyro/control/control_loops.h"
#include "ring_gyro/resonator/plant_simulator.h"
#include "ring_gyro/signals/calibration_command.h"
#include "ring_gyro/signals/decision_queue.h"
#include "ring_gyro/simulation/loop_configuration.h"

namespace cvg {

/// A calibration run in one process: plant, loops and procedure, called in the order in which the
/// lockstep graph exchanges its messages, so that the results are the same.
class CalibrationRun {
 public:
  /// `configuration.corrections` acts from the start. Throws std::invalid_argument.
  explicit CalibrationRun(const LoopConfiguration& configuration);

  struct Step {
    const PlantTruth& truth;
    const LoopOutput& loops;
    const std::optional<CalibrationCommand>& command;
  };
  /// One block. The references in the result are valid until the next call.
  Step step();

  const CalibrationResult& result() const { return procedure_.result(); }
  double time() const;  ///< since the start [s]

 private:
  PlantSimulator plant_;
  ControlLoops loops_;
  CalibrationProcedure procedure_;
  DecisionQueue<CalibrationCommand> commands_;
  std::int64_t start_ns_;
  bool started_ = false;
  PlantTruth truth_;
  const LoopOutput* output_ = nullptr;
  std::optional<CalibrationCommand> command_;
};

}  // namespace cvg
