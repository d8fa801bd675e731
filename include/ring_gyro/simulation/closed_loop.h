#pragma once

#include <cstdint>

#include "ring_gyro/compensation/compensation_injector.h"
#include "ring_gyro/control/control_loops.h"
#include "ring_gyro/identification/filter/identifier.h"
#include "ring_gyro/resonator/plant_simulator.h"
#include "ring_gyro/signals/compensation_decision.h"
#include "ring_gyro/signals/decision_queue.h"
#include "ring_gyro/simulation/loop_configuration.h"

namespace cvg {

/// All results of one block.
struct LoopRecord {
  const DisplacementBlock& displacement;
  const LoopOutput& loops;
  const ParameterEstimate* estimate;     ///< null except at the end of a period
  const CompensationDecision* decision;  ///< null when there is no estimate
  const PlantSimulator& plant;

  /// Computed on request.
  PlantTruth truth() const { return plant.truth(); }
};

/// The whole loop in one process: the classes that the nodes use, called in the order in which the
/// lockstep graph exchanges its messages, so that the results are the same.
class ClosedLoop {
 public:
  explicit ClosedLoop(const LoopConfiguration& configuration);
  ClosedLoop(const ClosedLoop&) = delete;
  ClosedLoop& operator=(const ClosedLoop&) = delete;

  /// One block. The references in the record are valid until the next call.
  LoopRecord step();

  PlantSimulator& plant() { return plant_; }
  ControlLoops& loops() { return loops_; }
  CompensationInjector& injector() { return injector_; }
  double time() const;  ///< since the start [s]

 private:
  PlantSimulator plant_;
  ControlLoops loops_;
  Identifier identifier_;
  CompensationInjector injector_;
  bool compensation_;
  DecisionQueue<CompensationDecision> decisions_;
  bool started_ = false;
  std::int64_t start_ns_;
  std::int64_t end_ns_ = 0;  // of the last block
  const LoopOutput* output_ = nullptr;
};

}  // namespace cvg
