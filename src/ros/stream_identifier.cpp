#include "ring_gyro/ros/stream_identifier.h"

#include <string>
#include <utility>

namespace ring_gyro::bridge {

StreamIdentifier::StreamIdentifier(const cvg::LoopConfiguration& configuration, Sink sink,
                                   std::uint64_t start_sequence)
    : identifier_(configuration.device, configuration.identification, configuration.converter),
      merge_([this](const cvg::OrbitalElements& elements, const cvg::ControlGains& gains) {
        process(elements, gains);
      }),
      sink_(std::move(sink)),
      start_sequence_(start_sequence),
      block_duration_ns_(configuration.converter.blockDurationNanoseconds()) {}

MessageFault StreamIdentifier::add(const ring_gyro::OrbitalElements& message) {
  MessageFault fault = readChecked(message, elements_);
  if (fault && report_.first_refused.empty()) {
    report_.first_refused =
        "orbital elements of block " + std::to_string(message.sequence) + ": " + fault.text;
  }
  merge_.add(elements_);
  return fault;
}

MessageFault StreamIdentifier::add(const ring_gyro::ControlGains& message) {
  MessageFault fault = readChecked(message, gains_);
  if (fault && report_.first_refused.empty()) {
    report_.first_refused =
        "control gains of block " + std::to_string(message.sequence) + ": " + fault.text;
  }
  merge_.add(gains_);
  return fault;
}

void StreamIdentifier::flush() {
  const cvg::PairMerge::Counts before = merge_.counts();
  merge_.flush();
  const cvg::PairMerge::Counts& after = merge_.counts();
  report_.alone_at_end += after.elements_alone - before.elements_alone;
  report_.alone_at_end += after.gains_alone - before.gains_alone;
}

void StreamIdentifier::process(const cvg::OrbitalElements& elements,
                               const cvg::ControlGains& gains) {
  const cvg::PairMerge::Counts& counts = merge_.counts();
  if (counts.pairs == 1) report_.alone_at_start = counts.elements_alone + counts.gains_alone;
  report_.last = elements.stamp;
  if (!started_ && elements.stamp.sequence < start_sequence_) {
    ++report_.before_start;
    return;
  }
  const std::uint64_t restarts = identifier_.restarts();
  const cvg::ParameterEstimate* const estimate = identifier_.process(elements, gains);
  if (!started_ || identifier_.restarts() != restarts) {
    report_.first = elements.stamp;
    report_.convergence_time.reset();
    report_.nis = {};
  }
  started_ = true;
  count(elements, gains);
  if (!estimate) return;
  account(*estimate);
  sink_(*report_.estimate);
}

/// Counts by the identifier's own rule, so exactly the blocks that it uses count as usable.
void StreamIdentifier::count(const cvg::OrbitalElements& elements, const cvg::ControlGains& gains) {
  const cvg::BlockUse use = identifier_.lastUse();
  if (use == cvg::BlockUse::kUsable) report_.frequency_sum += gains.reference_frequency;
  if (use == cvg::BlockUse::kWrongDuration && report_.uses.of(use) == 0) {
    report_.wrong_duration_ns = elements.stamp.duration_ns;
  }
  report_.uses.add(use);
}

void StreamIdentifier::account(const cvg::ParameterEstimate& estimate) {
  report_.estimate = estimate;
  if (estimate.updated) {
    report_.nis.add(estimate.normalised_innovation_squared, report_.convergence_time.has_value());
  }
  if (estimate.converged && !report_.convergence_time) {
    report_.convergence_time =
        estimate.stamp.end() - report_.first.end() + report_.first.duration();
  }
}

IdentificationReport StreamIdentifier::report() const {
  IdentificationReport report = report_;
  report.pairs = merge_.counts();
  report.elements = merge_.elementsCounts();
  report.gains = merge_.gainsCounts();
  report.filter_restarts = identifier_.restarts();
  return report;
}

}  // namespace ring_gyro::bridge
