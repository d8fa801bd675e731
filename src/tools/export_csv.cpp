// rosrun ring_gyro export_csv: elements and gains of a bag as a table that import_csv reads back.

#include <boost/program_options.hpp>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>

#include "command_line.h"
#include "progress_bar.h"
#include "ring_gyro/common/output_target.h"
#include "ring_gyro/common/whole_file.h"
#include "ring_gyro/logs/log_table.h"
#include "ring_gyro/ros/bag_signals.h"
#include "ring_gyro/signals/pair_merge.h"

namespace ring_gyro::tools {
namespace {

namespace options = boost::program_options;

struct Arguments {
  std::string bag_file;
  std::string log_file;
};

/// Empty when the program has already printed what was requested (--help).
std::optional<Arguments> parse(int argc, char** argv) {
  Arguments arguments;
  options::options_description description("export_csv");
  description.add_options()("help,h", "this text")("bag", options::value(&arguments.bag_file),
                                                   "recorded run (or the only argument)")(
      "output,o", options::value(&arguments.log_file), "table to write");
  const options::variables_map values = parseCommandLine(argc, argv, description, "bag", 1);
  if (values.count("help") != 0) {
    std::cout << "usage: export_csv BAG --output LOG.csv\n" << description;
    return std::nullopt;
  }
  if (arguments.bag_file.empty()) {
    throw options::error("the bag is missing; see export_csv --help");
  }
  if (arguments.log_file.empty()) {
    throw options::error("--output LOG.csv is missing; see export_csv --help");
  }
  return arguments;
}

/// Gives the number of messages of both topics.
double requireTopics(const bridge::BagFile& bag) {
  std::map<std::string, int> topics;  // by type
  std::map<std::string, double> messages;
  for (const bridge::BagConnection& connection : bag.connections()) {
    ++topics[connection.type];
    messages[connection.type] += static_cast<double>(connection.messages);
  }
  for (const char* type : {"ring_gyro/OrbitalElements", "ring_gyro/ControlGains"}) {
    if (topics[type] == 1) continue;
    throw std::runtime_error(topics[type] == 0
                                 ? std::string("no messages of ") + type +
                                       "; record the topics orbital_elements and control_gains"
                                 : std::string("several topics of ") + type +
                                       "; choose one with rosbag filter");
  }
  return messages["ring_gyro/OrbitalElements"] + messages["ring_gyro/ControlGains"];
}

void exportBag(const Arguments& arguments) {
  cvg::requireApart({arguments.log_file}, {arguments.bag_file});
  bridge::BagFile bag(arguments.bag_file);
  bag.requireWhole();
  ProgressBar progress(requireTopics(bag), "messages");
  cvg::WholeFile out(arguments.log_file);
  out.write(cvg::logHeader());
  std::string row;
  std::optional<std::uint32_t> session;
  std::uint64_t rows = 0;
  cvg::PairMerge merge([&](const cvg::OrbitalElements& elements, const cvg::ControlGains& gains) {
    // A table has one growing time, so it can contain only one session.
    if (session.value_or(elements.stamp.session) != elements.stamp.session) {
      throw std::runtime_error("holds several sessions; split it with rosbag filter");
    }
    session = elements.stamp.session;
    row.clear();
    cvg::appendLogRow(elements, gains, row);
    out.write(row);
    ++rows;
  });
  bridge::RefusedMessages refused;
  double messages = 0.0;
  const auto add = [&](const auto& signal) {
    merge.add(signal);
    progress.show(messages += 1.0);
  };
  bridge::BagSinks sinks;
  bridge::addSignals<ring_gyro::OrbitalElements, cvg::OrbitalElements>(bag, add, sinks, refused);
  bridge::addSignals<ring_gyro::ControlGains, cvg::ControlGains>(bag, add, sinks, refused);
  bag.read(sinks);
  bag.requireWhole();
  merge.flush();
  progress.clear();
  if (rows == 0) {
    throw std::runtime_error("no block has both its elements and its gains" +
                             (refused.count > 0 ? "; " + refused.text() : std::string()));
  }
  out.finish();
  if (refused.count > 0) std::fprintf(stderr, "export_csv: %s\n", refused.text().c_str());
  const cvg::PairMerge::Counts& counts = merge.counts();
  std::printf("exported   %lu rows to %s\n", static_cast<unsigned long>(rows),
              arguments.log_file.c_str());
  if (counts.elements_alone + counts.gains_alone > 0) {
    std::printf("left out   %lu elements and %lu gains without their partner\n",
                static_cast<unsigned long>(counts.elements_alone),
                static_cast<unsigned long>(counts.gains_alone));
  }
}

void run(const Arguments& arguments) {
  try {
    exportBag(arguments);
  } catch (const bridge::BagError&) {
    throw;
  } catch (const std::runtime_error& error) {
    const std::string what = error.what();
    const bool named = what.rfind(arguments.log_file, 0) == 0;
    throw std::runtime_error(named ? what : arguments.bag_file + ": " + what);
  }
}

}  // namespace
}  // namespace ring_gyro::tools

int main(int argc, char** argv) {
  try {
    if (const auto arguments = ring_gyro::tools::parse(argc, argv))
      ring_gyro::tools::run(*arguments);
    return EXIT_SUCCESS;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "export_csv: %s\n", error.what());
    return EXIT_FAILURE;
  }
}
