#include "ring_gyro/ros/stream_identifier.h"

#include <cmath>
#include <utility>

#include "ring_gyro/ros/conversions.h"

namespace ring_gyro {
namespace {

/// A sum is finite only when all of it is.
bool finite(const OrbitalElements& elements, const ControlGains& gains) {
  const Orbit& orbit = elements.orbit;
  const Eigen::Vector2cd drive = gains.drive.total();
  return std::isfinite(orbit.a + orbit.b + orbit.theta + orbit.phi + elements.group_delay) &&
         std::isfinite(drive.x().real() + drive.x().imag() + drive.y().real() + drive.y().imag()) &&
         std::isfinite(gains.reference_frequency);
}

}  // namespace

StreamIdentifier::StreamIdentifier(const LoopConfiguration& configuration, Sink sink,
                                   std::uint64_t start_sequence)
    : identifier_(configuration.identification, configuration.converter),
      merge_([this](const OrbitalElements& elements, const ControlGains& gains) {
        process(elements, gains);
      }),
      sink_(std::move(sink)),
      start_sequence_(start_sequence),
      block_duration_ns_(configuration.converter.blockDurationNanoseconds()) {}

void StreamIdentifier::add(const ring_gyro_msgs::OrbitalElements& message) {
  fromMessage(message, elements_);
  merge_.add(elements_);
}

void StreamIdentifier::add(const ring_gyro_msgs::ControlGains& message) {
  fromMessage(message, gains_);
  merge_.add(gains_);
}

void StreamIdentifier::flush() {
  const PairMerge::Counts before = merge_.counts();
  merge_.flush();
  const PairMerge::Counts& after = merge_.counts();
  report_.alone_at_end += after.elements_alone - before.elements_alone;
  report_.alone_at_end += after.gains_alone - before.gains_alone;
}

void StreamIdentifier::process(const OrbitalElements& elements, const ControlGains& gains) {
  const PairMerge::Counts& counts = merge_.counts();
  if (counts.pairs == 1) report_.alone_at_start = counts.elements_alone + counts.gains_alone;
  report_.last = elements.stamp;
  if (!started_ && elements.stamp.sequence < start_sequence_) {
    ++report_.before_start;
    return;
  }
  const std::uint64_t restarts = identifier_.restarts();
  const ParameterEstimate* const estimate = identifier_.process(elements, gains);
  if (!started_ || identifier_.restarts() != restarts) {
    report_.first = elements.stamp;
    report_.convergence_time.reset();
    report_.updates = 0;
    report_.nis_sum = 0.0;
    report_.updates_converged = 0;
    report_.nis_sum_converged = 0.0;
  }
  started_ = true;
  count(elements, gains);
  if (!estimate) return;
  account(*estimate);
  sink_(*estimate, identifier_.covariance());
}

void StreamIdentifier::count(const OrbitalElements& elements, const ControlGains& gains) {
  UnusableBlocks& unusable = report_.unusable;
  const LoopStatus& sensed = elements.status;
  const LoopStatus& acted = gains.status;
  if (!finite(elements, gains)) {
    ++unusable.not_finite;
  } else if (elements.stamp.duration_ns != block_duration_ns_) {
    if (unusable.wrong_duration++ == 0) report_.wrong_duration_ns = elements.stamp.duration_ns;
  } else if (!(std::abs(elements.orbit.b) < elements.orbit.a)) {
    ++unusable.no_amplitude;
  } else if (sensed.usable() && acted.usable()) {
    ++report_.usable;
    report_.frequency_sum += gains.reference_frequency;
  } else if (sensed.invalid_samples || acted.invalid_samples) {
    ++unusable.invalid_samples;
  } else if (sensed.converter_saturated || acted.converter_saturated || sensed.drive_saturated ||
             acted.drive_saturated) {
    ++unusable.saturated;
  } else {
    ++unusable.not_locked;
  }
}

void StreamIdentifier::account(const ParameterEstimate& estimate) {
  report_.estimate = estimate;
  if (estimate.updated) {
    ++report_.updates;
    report_.nis_sum += estimate.normalised_innovation_squared;
    if (report_.convergence_time) {
      ++report_.updates_converged;
      report_.nis_sum_converged += estimate.normalised_innovation_squared;
    }
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
  report.covariance = identifier_.covariance();
  return report;
}

}  // namespace ring_gyro
