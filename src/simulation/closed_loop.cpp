#include "ring_gyro/simulation/closed_loop.h"

namespace ring_gyro {

ClosedLoop::ClosedLoop(const LoopConfiguration& configuration)
    : plant_(configuration.plant, configuration.converter,
             static_cast<std::uint64_t>(configuration.run.seed),
             configuration.run.sessionIdentifier(), configuration.run.startNanoseconds()),
      loops_(configuration.control, configuration.demodulation, configuration.converter,
             configuration.calibration),
      identifier_(configuration.identification, configuration.converter),
      injector_(configuration.compensation, identifier_.periodBlocks()),
      compensation_(configuration.control.compensation),
      start_ns_(configuration.run.startNanoseconds()) {}

LoopRecord ClosedLoop::step() {
  const DisplacementBlock& block = started_ ? plant_.step(output_->command) : plant_.start();
  started_ = true;
  end_ns_ = block.stamp.end_ns;

  // The command that answers this block acts in the next one.
  const std::uint64_t acts_in = block.stamp.sequence + 1;
  while (pending_count_ > 0 && pending_[first_pending_].effective_sequence <= acts_in) {
    loops_.setCompensation(pending_[first_pending_].gains);
    first_pending_ = 1 - first_pending_;
    --pending_count_;
  }
  output_ = &loops_.process(block);

  const ParameterEstimate* const estimate = identifier_.process(output_->elements, output_->gains);
  decision_.reset();
  if (estimate != nullptr) {
    decision_ = injector_.decide(*estimate);
    if (compensation_) {
      Pending& last = pending_[(first_pending_ + pending_count_++) % 2];
      last = {decision_->effective_sequence, decision_->gains};
    }
  }
  return {block, *output_, estimate, decision_, plant_, identifier_};
}

double ClosedLoop::time() const {
  return started_ ? 1e-9 * static_cast<double>(end_ns_ - start_ns_) : 0.0;
}

}  // namespace ring_gyro
