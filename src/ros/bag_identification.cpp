#include "ring_gyro/ros/bag_identification.h"

#include <algorithm>
#include <exception>
#include <stdexcept>
#include <thread>
#include <utility>

#include "ring_gyro/ros/batch_queue.h"
#include "ring_gyro/ros/conversions.h"
#include "ring_gyro/ros/stream_identifier.h"

namespace ring_gyro {
namespace {

constexpr std::size_t kBatch = 512;

/// A message of either topic.
struct Signal {
  bool is_elements = false;
  OrbitalElements elements;
  ControlGains gains;
  ros::Time time;
};

/// Reads bags in a thread of its own: what decompresses and what identifies take about as long.
class BagReader {
 public:
  BagReader(std::vector<LoopBag>& bags, const ros::Time& from, const ros::Time& to)
      : bags_(bags), from_(from), to_(to), thread_([this] { run(); }) {}
  ~BagReader() {
    signals_.cancel();
    if (thread_.joinable()) thread_.join();
  }
  BagReader(const BagReader&) = delete;
  BagReader& operator=(const BagReader&) = delete;

  bool take(std::vector<Signal>& batch) { return signals_.take(batch); }
  /// Once take() has said false. Throws what reading threw.
  void finish() {
    thread_.join();
    if (error_) std::rethrow_exception(error_);
  }

 private:
  struct Cancelled {};

  void run() {
    try {
      batch_.reserve(kBatch);
      for (LoopBag& bag : bags_) readBag(bag);
      if (!batch_.empty()) signals_.give(batch_);
    } catch (const Cancelled&) {
    } catch (...) {
      error_ = std::current_exception();
    }
    signals_.close();
  }

  void readBag(LoopBag& bag) {
    bag.read(
        [this](const ring_gyro_msgs::OrbitalElements& message, const ros::Time& time) {
          Signal& signal = next(time);
          signal.is_elements = true;
          fromMessage(message, signal.elements);
        },
        [this](const ring_gyro_msgs::ControlGains& message, const ros::Time& time) {
          Signal& signal = next(time);
          signal.is_elements = false;
          fromMessage(message, signal.gains);
        },
        from_, to_);
  }

  Signal& next(const ros::Time& time) {
    if (batch_.size() == kBatch && !signals_.give(batch_)) throw Cancelled();
    batch_.emplace_back();
    batch_.back().time = time;
    return batch_.back();
  }

  std::vector<LoopBag>& bags_;
  ros::Time from_;
  ros::Time to_;
  BatchQueue<Signal> signals_;
  std::vector<Signal> batch_;
  std::exception_ptr error_;
  std::thread thread_;
};

}  // namespace

BagIdentification::BagIdentification(const std::vector<std::string>& paths,
                                     LoopConfiguration configuration,
                                     BagIdentificationOptions options)
    : configuration_(std::move(configuration)), options_(std::move(options)) {
  // What is wrong with the configuration is said before bags are opened.
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
  const auto take = [&on_estimate](const ParameterEstimate& estimate) {
    if (!estimate.value.allFinite() || !estimate.covariance.allFinite()) {
      throw std::runtime_error("the estimate of block " + std::to_string(estimate.stamp.sequence) +
                               " is not finite");
    }
    if (on_estimate) on_estimate(estimate);
  };
  StreamIdentifier identifier(configuration_, take, options_.start_sequence);
  try {
    BagReader reader(bags_, from_, to_);
    std::vector<Signal> batch;
    while (reader.take(batch)) {
      for (const Signal& signal : batch) {
        if (signal.is_elements) {
          identifier.add(signal.elements);
        } else {
          identifier.add(signal.gains);
        }
      }
      if (on_progress && !batch.empty()) on_progress((batch.back().time - from_).toSec());
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

}  // namespace ring_gyro
