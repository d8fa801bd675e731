#include "ring_gyro/simulation/calibration_run.h"

namespace cvg {

CalibrationRun::CalibrationRun(const LoopConfiguration& configuration)
    : plant_(configuration.plant, configuration.converter,
             static_cast<std::uint64_t>(configuration.run.seed),
             configuration.run.sessionIdentifier(), configuration.run.startNanoseconds()),
      loops_(configuration.device, configuration.control, configuration.demodulation,
             configuration.converter, configuration.corrections),
      procedure_(configuration.device, configuration.calibration_run, configuration.extended,
                 configuration.converter, static_cast<std::int64_t>(configuration.periodBlocks()),
                 configuration.corrections),
      commands_(configuration.periodBlocks()),
      start_ns_(configuration.run.startNanoseconds()) {}

CalibrationRun::Step CalibrationRun::step() {
  if (started_) plant_.setRotationRate(output_->command.table_rate);
  const DisplacementBlock& block = started_ ? plant_.step(output_->command) : plant_.start();
  started_ = true;
  truth_ = plant_.truth();
  const std::uint64_t acts_in = block.stamp.sequence + 1;
  commands_.applyDue(block.stamp.session, acts_in, [this](const CalibrationCommand& command) {
    loops_.setSettings(command.settings);
  });
  output_ = &loops_.process(block);
  command_ = procedure_.process(output_->elements, output_->gains);
  if (command_) commands_.add(*command_);
  return {truth_, *output_, command_};
}

double CalibrationRun::time() const {
  return started_ ? 1e-9 * static_cast<double>(truth_.stamp.end_ns - start_ns_) : 0.0;
}

}  // namespace cvg
