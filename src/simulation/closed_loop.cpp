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
  truth_ = plant_.truth();

  // The command that answers this block acts in the next one.
  const std::uint64_t acts_in = block.stamp.sequence + 1;
  while (!pending_.empty() && pending_.front().effective_sequence <= acts_in) {
    loops_.setCompensation(pending_.front().gains);
    pending_.pop_front();
  }
  output_ = &loops_.process(block);

  estimate_ = identifier_.process(output_->elements, output_->gains);
  decision_.reset();
  if (estimate_) {
    decision_ = injector_.decide(*estimate_);
    if (compensation_) pending_.push_back(*decision_);
  }
  return {block, *output_, truth_, estimate_, decision_};
}

double ClosedLoop::time() const {
  return started_ ? 1e-9 * static_cast<double>(truth_.stamp.end_ns - start_ns_) : 0.0;
}

}  // namespace ring_gyro
