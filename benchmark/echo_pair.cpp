// The bare echo pair with which the lockstep graph is compared: two processes that only exchange
// the messages of plant and loops with plain roscpp.
//
//   echo_pair loops                         answers each displacement block with a drive command
//   echo_pair plant BLOCKS SAMPLES          sends blocks of SAMPLES, each after the answer to the
//                                           one before; prints blocks per second and ends
//   echo_pair ... --network-thread          with the spinner of this package's nodes

#include <ros/ros.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>

#include "ring_gyro/nodes/network_thread_spinner.h"
#include "ring_gyro/ros/messages.h"
#include "ring_gyro/ros/topics.h"

namespace ring_gyro::benchmark {
namespace {

using Block = ring_gyro::DisplacementBlock;
using Command = ring_gyro::DriveCommand;

/// ros::spin(), or the spinner of this package's nodes.
class Spinner {
 public:
  explicit Spinner(bool network_thread) {
    if (network_thread) spinner_ = std::make_unique<nodes::NetworkThreadSpinner>();
  }
  void use(ros::NodeHandle& handle) {
    if (spinner_) handle.setCallbackQueue(spinner_->queue());
  }
  void run() {
    if (spinner_) {
      spinner_->run();
    } else {
      ros::spin();
    }
  }
  void stop() {
    if (spinner_) {
      spinner_->stop();
    } else {
      ros::requestShutdown();
    }
  }

 private:
  std::unique_ptr<nodes::NetworkThreadSpinner> spinner_;
};

void answer(Spinner& spinner) {
  ros::NodeHandle handle;
  spinner.use(handle);
  ros::Publisher commands = handle.advertise<Command>(bridge::topics::kDriveCommand, 0);
  const ros::Subscriber blocks = handle.subscribe<Block>(
      bridge::topics::kDisplacement, 0,
      [&commands](const Block::ConstPtr& block) {
        const auto command = boost::make_shared<Command>();
        command->header.stamp = block->header.stamp;
        command->session = block->session;
        command->answers_sequence = block->sequence;
        commands.publish(command);
      },
      ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay());
  spinner.run();
}

void ask(Spinner& spinner, std::uint64_t count, std::size_t samples) {
  ros::NodeHandle handle;
  spinner.use(handle);
  ros::Publisher blocks = handle.advertise<Block>(bridge::topics::kDisplacement, 0);
  std::uint64_t sequence = 0;
  const auto send = [&] {
    const auto block = boost::make_shared<Block>();
    block->sequence = sequence;
    block->x.assign(samples, 0.5);
    block->y.assign(samples, 0.25);
    blocks.publish(block);
  };
  std::chrono::steady_clock::time_point begin;
  const ros::Subscriber commands = handle.subscribe<Command>(
      bridge::topics::kDriveCommand, 0,
      [&](const Command::ConstPtr& command) {
        if (command->answers_sequence != sequence) return;
        if (++sequence < count) {
          send();
          return;
        }
        const double wall =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
        std::printf("%.1f\n", static_cast<double>(count) / wall);
        std::fflush(stdout);
        spinner.stop();
      },
      ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay());
  while (ros::ok() && (blocks.getNumSubscribers() == 0 || commands.getNumPublishers() == 0)) {
    ros::WallDuration(0.01).sleep();
  }
  begin = std::chrono::steady_clock::now();
  send();
  spinner.run();
}

}  // namespace
}  // namespace ring_gyro::benchmark

int main(int argc, char** argv) {
  using namespace ring_gyro::benchmark;
  const bool network_thread = std::strcmp(argv[argc - 1], "--network-thread") == 0;
  if (network_thread) --argc;
  const bool plant = argc == 4 && std::strcmp(argv[1], "plant") == 0;
  if (!plant && !(argc == 2 && std::strcmp(argv[1], "loops") == 0)) {
    std::fprintf(stderr, "usage: echo_pair loops | plant BLOCKS SAMPLES [--network-thread]\n");
    return EXIT_FAILURE;
  }
  const std::uint64_t blocks = plant ? std::strtoull(argv[2], nullptr, 10) : 0;
  const std::size_t samples = plant ? std::strtoull(argv[3], nullptr, 10) : 0;
  ros::init(argc, argv, plant ? "echo_plant" : "echo_loops", ros::init_options::NoRosout);
  Spinner spinner(network_thread);
  ros::start();
  if (plant) {
    ask(spinner, blocks, samples);
  } else {
    answer(spinner);
  }
  ros::shutdown();
  return EXIT_SUCCESS;
}
