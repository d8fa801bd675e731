// rosrun ring_gyro validate_bag: the faults of recorded runs.

#include <console_bridge/console.h>

#include <algorithm>
#include <boost/program_options.hpp>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <string>
#include <vector>

#include "command_line.h"
#include "ring_gyro/ros/bag_validation.h"

namespace ring_gyro::tools {
namespace {

namespace options = boost::program_options;

constexpr int kFine = 0;
constexpr int kWarnings = 1;
constexpr int kFaults = 2;

int validate(const std::string& path, const bridge::LoopTopics& topics) {
  try {
    const bridge::BagValidation result = bridge::validateBag(path, topics);
    std::printf("%s: %s\n", path.c_str(), result.summary.c_str());
    for (const bridge::Finding& finding : result.findings) {
      std::printf("%s: %s: %s\n", path.c_str(),
                  finding.severity == bridge::Severity::kFault ? "fault" : "warning",
                  finding.text.c_str());
    }
    if (result.findings.empty()) std::printf("%s: fine\n", path.c_str());
    return result.hasFault() ? kFaults : result.findings.empty() ? kFine : kWarnings;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return kFaults;
  }
}

int run(int argc, char** argv) {
  std::vector<std::string> bags;
  bridge::LoopTopics topics;
  options::options_description description("validate_bag");
  description.add_options()("help,h", "this text")("bag", options::value(&bags), "recorded runs")(
      "elements", options::value(&topics.elements), "topic of the orbital elements")(
      "gains", options::value(&topics.gains), "topic of the control gains");
  const options::variables_map values = parseCommandLine(argc, argv, description, "bag");
  if (values.count("help") != 0) {
    std::cout << "usage: validate_bag RUN.bag [MORE.bag ...]\n"
              << description
              << "\nExit status: 0 fine; 1 warnings; 2 faults, or a bag that cannot be read.\n";
    return kFine;
  }
  if (bags.empty()) throw options::error("no bag given; see validate_bag --help");
  int worst = kFine;
  for (const std::string& bag : bags) worst = std::max(worst, validate(bag, topics));
  return worst;
}

}  // namespace
}  // namespace ring_gyro::tools

int main(int argc, char** argv) {
  console_bridge::noOutputHandler();  // faults are reported once, here
  try {
    return ring_gyro::tools::run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "validate_bag: %s\n", error.what());
    return ring_gyro::tools::kFaults;
  }
}
