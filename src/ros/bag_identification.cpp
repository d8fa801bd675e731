#include "ring_gyro/ros/bag_identification.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <exception>
#include <stdexcept>
#include <thread>
#include <utility>

#include "ring_gyro/ros/batch_queue.h"
#include "ring_gyro/ros/stream_identifier.h"

namespace ring_gyro::bridge {
namespace {

constexpr std::size_t kBatchBytes = 128 * 1024;

/// Header of a message in a batch; the bytes of the message follow.
struct BatchEntry {
  bool is_elements;
  std::uint32_t size;
  ros::Time time;
};

using Batch = std::vector<std::uint8_t>;

void append(Batch& batch, const SerialisedMessage& message) {
  const BatchEntry entry{message.is_elements, message.size, message.time};
  const std::size_t end = batch.size();
  batch.resize(end + sizeof entry + message.size);
  std::memcpy(&batch[end], &entry, sizeof entry);
  std::memcpy(&batch[end + sizeof entry], message.bytes, message.size);
}

template <typename OnMessage>
void forEach(Batch& batch, OnMessage on_message) {
  for (std::size_t begin = 0; begin < batch.size();) {
    BatchEntry entry;
    std::memcpy(&entry, &batch[begin], sizeof entry);
    begin += sizeof entry;
    on_message(SerialisedMessage{entry.is_elements, &batch[begin], entry.size, entry.time});
    begin += entry.size;
  }
}

/// Reads bags in a separate thread, without deserialising the messages, because finding and
/// decompressing the messages takes longer than identifying from them.
class BagReader {
 public:
  BagReader(std::vector<LoopBag>& bags, const ros::Time& from, const ros::Time& to)
      : bags_(bags), from_(from), to_(to), thread_([this] { run(); }) {}
  ~BagReader() {
    batches_.cancel();
    if (thread_.joinable()) thread_.join();
  }
  BagReader(const BagReader&) = delete;
  BagReader& operator=(const BagReader&) = delete;

  bool take(Batch& batch) { return batches_.take(batch); }
  /// To be called after take() has returned false. Throws what the reading threw.
  void finish() {
    thread_.join();
    if (error_) std::rethrow_exception(error_);
  }

 private:
  struct Cancelled {};

  void run() {
    try {
      for (LoopBag& bag : bags_) readBag(bag);
      if (!batch_.empty()) batches_.give(batch_);
    } catch (const Cancelled&) {
    } catch (...) {
      error_ = std::current_exception();
    }
    batches_.close();
  }

  void readBag(LoopBag& bag) {
    bag.read(
        [this](const SerialisedMessage& message) {
          if (batch_.size() >= kBatchBytes && !batches_.give(batch_)) throw Cancelled();
          append(batch_, message);
        },
        from_, to_);
  }

  std::vector<LoopBag>& bags_;
  ros::Time from_;
  ros::Time to_;
  BatchQueue<std::uint8_t> batches_;
  Batch batch_;
  std::exception_ptr error_;
  std::thread thread_;
};

}  // namespace

BagIdentification::BagIdentification(const std::vector<std::string>& paths,
                                     cvg::LoopConfiguration configuration,
                                     BagIdentificationOptions options)
    : configuration_(std::move(configuration)), options_(std::move(options)) {
  // Report faults of the configuration before bags are opened.
  const StreamIdentifier trial(configuration_, {});
  for (const std::string& path : paths) bags_.emplace_back(path, options_.topics);
  if (bags_.empty()) throw BagError("no bag to identify from");
  std::stable_sort(bags_.begin(), bags_.end(),
                   [](const LoopBag& a, const LoopBag& b) { return a.begin() < b.begin(); });
  ros::Time end = bags_.front().end();
  for (const LoopBag& bag : bags_) end = std::max(end, bag.end());
  from_ = bags_.front().begin() + ros::Duration(options_.start);
  to_ = options_.duration ? from_ + ros::Duration(*options_.duration) : end;
  if (from_ > end) {
    throw BagError(bags_.front().path() + ": ends " +
                   std::to_string((end - bags_.front().begin()).toSec()) +
                   " s after its begin; give a smaller --start");
  }
  to_ = std::min(to_, end);
}

IdentificationResult BagIdentification::run(const OnEstimate& on_estimate,
                                            const OnProgress& on_progress) {
  const auto take = [&on_estimate](const cvg::ParameterEstimate& estimate) {
    if (!estimate.isFinite()) {
      throw std::runtime_error("the estimate of block " + std::to_string(estimate.stamp.sequence) +
                               " is not finite");
    }
    if (on_estimate) on_estimate(estimate);
  };
  StreamIdentifier identifier(configuration_, take, options_.start_sequence);
  try {
    BagReader reader(bags_, from_, to_);
    Batch batch;
    ring_gyro::OrbitalElements elements;
    ring_gyro::ControlGains gains;
    ros::Time last = from_;
    while (reader.take(batch)) {
      forEach(batch, [&](const SerialisedMessage& message) {
        if (message.is_elements) {
          deserialise(message, elements);
          identifier.add(elements);
        } else {
          deserialise(message, gains);
          identifier.add(gains);
        }
        last = message.time;
      });
      if (on_progress && !batch.empty()) on_progress((last - from_).toSec());
    }
    reader.finish();
  } catch (const std::exception& error) {
    throw BagError(bags_.front().path() + ": " + error.what());
  }
  identifier.flush();
  IdentificationResult result;
  for (const LoopBag& bag : bags_) {
    result.sources.push_back(bag.path());
    result.damage.insert(result.damage.end(), bag.damage().begin(), bag.damage().end());
  }
  result.report = identifier.report();
  return result;
}

}  // namespace ring_gyro::bridge
