#include "ring_gyro/simulation/closed_loop.h"

#include "ring_gyro/signals/compensation_decision.h"

namespace cvg {

ClosedLoop::ClosedLoop(const LoopConfiguration& configuration)
    : plant_(configuration.plant, configuration.converter,
             static_cast<std::uint64_t>(configuration.run.seed),
             configuration.run.sessionIdentifier(), configuration.run.startNanoseconds()),
      loops_(configuration.device, configuration.control, configuration.demodulation,
             configuration.converter, configuration.corrections),
      identifier_(configuration.device, configuration.identification, configuration.converter),
      injector_(configuration.device, configuration.compensation, identifier_.periodBlocks()),
      compensation_(configuration.control.compensation),
      decisions_(configuration.periodBlocks()),
      start_ns_(configuration.run.startNanoseconds()) {}

LoopRecord ClosedLoop::step() {
  const DisplacementBlock& block = started_ ? plant_.step(output_->command) : plant_.start();
  started_ = true;
  end_ns_ = block.stamp.end_ns;

  // The command that answers this block acts in the next one.
  const std::uint64_t acts_in = block.stamp.sequence + 1;
  decisions_.applyDue(block.stamp.session, acts_in, [this](const CompensationDecision& decision) {
    loops_.setCompensation(decision.gains);
  });
  output_ = &loops_.process(block);

  const ParameterEstimate* const estimate = identifier_.process(output_->elements, output_->gains);
  const CompensationDecision* const decision =
      estimate != nullptr ? &injector_.decide(*estimate) : nullptr;
  if (compensation_ && decision != nullptr) decisions_.add(*decision);
  return {block, *output_, estimate, decision, plant_};
}

double ClosedLoop::time() const {
  return started_ ? 1e-9 * static_cast<double>(end_ns_ - start_ns_) : 0.0;
}

}  // namespace cvg
