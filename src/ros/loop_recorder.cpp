#include "ring_gyro/ros/loop_recorder.h"

#include "ring_gyro/ros/conversions.h"
#include "ring_gyro/ros/topics.h"

namespace ring_gyro::bridge {

LoopRecorder::LoopRecorder(const std::string& path, bool raw) : writer_(path), raw_(raw) {}

template <typename Message>
void LoopRecorder::write(const char* topic, Message& message) {
  writer_.write(topic, message);
  ++message.header.seq;  // counts like that of a publisher
}

void LoopRecorder::write(const cvg::LoopRecord& record) {
  if (raw_) {
    toMessage(record.displacement, displacement_);
    write(topics::kDisplacement, displacement_);
    toMessage(record.loops.command, record.displacement.stamp, command_);
    write(topics::kDriveCommand, command_);
  }
  toMessage(record.truth(), truth_);
  write(topics::kPlantTruth, truth_);
  toMessage(record.loops.elements, elements_);
  write(topics::kOrbitalElements, elements_);
  toMessage(record.loops.gains, gains_);
  write(topics::kControlGains, gains_);
  if (record.estimate) {
    toMessage(*record.estimate, estimate_);
    write(topics::kParameterEstimate, estimate_);
  }
  if (record.decision) {
    toMessage(*record.decision, estimate_.header.stamp, compensation_);
    write(topics::kCompensationGains, compensation_);
  }
}

void LoopRecorder::finish(const cvg::BlockStamp& last, bool cut) {
  if (!cut) {
    ring_gyro::EndOfRun end;
    end.header.stamp = timeFromNanoseconds(last.end_ns);
    end.session = last.session;
    end.last_sequence = last.sequence;
    writer_.write(topics::kEndOfRun, end);
  }
  writer_.finish();
}

}  // namespace ring_gyro::bridge
