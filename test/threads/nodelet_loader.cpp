// A manager of nodelets that can be built with a sanitizer, which ROS's own cannot:
//   nodelet_loader NAME...    loads ring_gyro/NAME as /NAME, in this order, and spins until the
//                             run ends
// NAME `seeded_race` is a nodelet of this file with a data race. A sanitizer that does not report
// it would not report one of the loop's either.

#include <nodelet/loader.h>
#include <nodelet/nodelet.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>

#include <boost/make_shared.hpp>
#include <boost/shared_ptr.hpp>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <pluginlib/class_loader.hpp>
#include <string>

#include "ring_gyro/ros/messages.h"
#include "ring_gyro/ros/topics.h"

namespace ring_gyro::test {
namespace {

/// Counts without a lock what it hears in the main thread, where all nodelets of the loop have
/// their callbacks, and looks at the count from a timer in a worker thread of the manager.
class SeededRace : public nodelet::Nodelet {
 private:
  void onInit() override {
    ros::NodeHandle in_main_thread(getNodeHandle());
    in_main_thread.setCallbackQueue(ros::getGlobalCallbackQueue());
    subscriber_ = in_main_thread.subscribe<OrbitalElements>(
        bridge::topics::kOrbitalElements, 10,
        [this](const boost::shared_ptr<const OrbitalElements>&) { ++heard_; });
    timer_ = getMTPrivateNodeHandle().createWallTimer(ros::WallDuration(0.01),
                                                      [this](const ros::WallTimerEvent&) {
                                                        if (heard_ > before_) before_ = heard_;
                                                      });
  }

  int heard_ = 0;
  int before_ = 0;
  ros::Subscriber subscriber_;
  ros::WallTimer timer_;
};

}  // namespace
}  // namespace ring_gyro::test

int main(int argc, char** argv) {
  ros::init(argc, argv, "gyroscope");
  ros::NodeHandle handle;  // keeps ROS running until the plant ends it
  try {
    pluginlib::ClassLoader<nodelet::Nodelet> plugins("nodelet", "nodelet::Nodelet");
    nodelet::Loader loader([&](const std::string& type) -> boost::shared_ptr<nodelet::Nodelet> {
      if (type == "ring_gyro/seeded_race") return boost::make_shared<ring_gyro::test::SeededRace>();
      return plugins.createInstance(type);
    });
    for (int place = 1; place < argc; ++place) {
      const std::string name = argv[place];
      if (!loader.load("/" + name, "ring_gyro/" + name, {}, {})) {
        std::cerr << "nodelet_loader: " << name << " was not loaded, see above\n";
        return EXIT_FAILURE;
      }
    }
    ros::spin();
  } catch (const std::exception& error) {
    std::cerr << "nodelet_loader: " << error.what() << '\n';
    return EXIT_FAILURE;
  }
  return EXIT_SUCCESS;
}
