// rosrun ring_gyro identify_batch: identifies many bags, one JSON line each, on all cores.

#include <console_bridge/console.h>

#include <boost/program_options.hpp>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <iostream>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "command_line.h"
#include "device_options.h"
#include "line_batch.h"
#include "progress_bar.h"
#include "ring_gyro/common/output_target.h"
#include "ring_gyro/common/parallel_for.h"
#include "ring_gyro/ros/bag_identification.h"

namespace ring_gyro::tools {
namespace {

namespace options = boost::program_options;
using Json = nlohmann::ordered_json;

constexpr char kProgram[] = "identify_batch";

struct Arguments {
  std::vector<std::string> bags;
  std::string list;
  DeviceOptions device;
  cvg::ItemRange range;
  std::size_t jobs = 0;
  std::string output;
  bool resume = false;
  std::vector<std::string> merge;
};

void addListed(const std::string& path, std::vector<std::string>& bags) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error(path + ": cannot be read; name a file with one bag a line");
  for (std::string line; std::getline(file, line);) {
    if (!line.empty()) bags.push_back(line);
  }
}

/// Empty when the program has already printed what was requested (--help).
std::optional<Arguments> parse(int argc, char** argv) {
  Arguments arguments;
  std::string shard;
  options::options_description description(kProgram);
  arguments.device.addTo(description);
  description.add_options()("help,h", "this text")("bag", options::value(&arguments.bags),
                                                   "recorded runs (or just their names)")(
      "list", options::value(&arguments.list), "file with one bag a line, after those named")(
      "shard", options::value(&shard), "K/N: of these bags only those with index % N = K")(
      "jobs", options::value(&arguments.jobs), "bags at a time; 0: as many as there are cores")(
      "output,o", options::value(&arguments.output), "file to which a JSON line is added per bag")(
      "resume", options::bool_switch(&arguments.resume),
      "leave out what the output file already holds; a line that was cut short is done again")(
      "merge", options::value(&arguments.merge)->multitoken(),
      "instead of identifying: joins these files by index, without duplicates, into --output if "
      "given");
  const options::variables_map values = parseCommandLine(argc, argv, description, "bag");
  if (values.count("help") != 0) {
    std::cout << "usage: identify_batch BAG ... --config FILE --output FILE [--shard K/N] "
                 "[--resume]\n       identify_batch --merge FILE ... [--output FILE]\n"
                 "Item n is the n-th bag, so every shard must be given the same list. A line is "
                 "{\"index\", \"bag\", \"status\", \"result\", \"refused\"}: status and result are "
                 "those of identify, refused says why there is nothing to rely on.\n"
              << description;
    return std::nullopt;
  }
  if (!arguments.merge.empty()) return arguments;
  if (!arguments.list.empty()) addListed(arguments.list, arguments.bags);
  if (arguments.bags.empty()) {
    throw options::error("no bag given; name some, or a file with --list");
  }
  if (arguments.output.empty()) throw options::error("--output FILE is missing");
  arguments.range.count = arguments.bags.size();
  setShard(shard, arguments.range);
  return arguments;
}

Json itemOf(std::uint64_t index, const std::string& bag,
            const cvg::LoopConfiguration& configuration) {
  Json item = {{"index", index}, {"bag", bag}};
  try {
    const bridge::IdentificationResult result =
        bridge::BagIdentification({bag}, configuration).run();
    item["status"] = static_cast<int>(bridge::verdictOf(result, configuration));
    item["result"] = Json::parse(bridge::identificationJson({result}, configuration));
    const std::string failure = bridge::failureOf(result.report, configuration);
    if (!failure.empty()) item["refused"] = bag + ": " + failure;
  } catch (const std::exception& error) {
    item["status"] = static_cast<int>(bridge::Verdict::kFailed);
    item["refused"] = error.what();
  }
  return item;
}

void merge(const Arguments& arguments) {
  std::size_t refused = 0;
  std::size_t faulty = 0;
  const LinesByIndex lines =
      mergeLines(kProgram, arguments.merge, arguments.output, [](std::uint64_t, const Json& item) {
        item.at("bag").get<std::string>();
        item.at("status").get<int>();
      });
  for (const auto& line : lines) {
    const Json item = Json::parse(line.second);
    if (item.contains("refused")) ++refused;
    if (item.at("status") == static_cast<int>(bridge::Verdict::kIdentifiedWithFaults)) ++faulty;
  }
  std::printf(
      "bags       %zu, %zu refused, %zu with lost or unusable data, or data that do not fit\n",
      lines.size(), refused, faulty);
}

/// Returns the number of bags that were refused.
std::size_t run(const Arguments& arguments) {
  const cvg::LoopConfiguration configuration = arguments.device.read();
  std::vector<std::string> inputs = arguments.bags;
  inputs.insert(inputs.end(), configuration.files.begin(), configuration.files.end());
  if (!arguments.list.empty()) inputs.push_back(arguments.list);
  cvg::requireApart({arguments.output}, inputs);
  LineBatch batch(kProgram, arguments.output, arguments.resume,
                  [&arguments](std::uint64_t index, const Json& item) {
                    const std::string bag = item.at("bag");
                    item.at("status").get<int>();
                    if (index < arguments.bags.size() && bag == arguments.bags[index]) return;
                    throw std::runtime_error("item " + std::to_string(index) + " is " + bag +
                                             ", not a bag of this list");
                  });
  const std::size_t there = batch.lines().size();
  const std::vector<std::uint64_t> left = batch.left(arguments.range);
  std::mutex mutex;
  std::size_t refused = 0;
  double done = 0.0;
  ProgressBar progress(static_cast<double>(left.size()), "bags");
  cvg::parallelFor(left.size(), arguments.jobs != 0 ? arguments.jobs : cvg::coreCount(),
                   [&](std::size_t k) {
                     const std::uint64_t index = left[k];
                     const Json item = itemOf(index, arguments.bags[index], configuration);
                     const std::lock_guard<std::mutex> lock(mutex);
                     if (item.contains("refused")) ++refused;
                     batch.add(index, asLine(item));
                     progress.showNow(done += 1.0);
                   });
  batch.finish();
  std::printf("bags       %zu done, %zu refused, %zu were there\n", left.size(), refused, there);
  return refused;
}

}  // namespace
}  // namespace ring_gyro::tools

int main(int argc, char** argv) {
  using namespace ring_gyro::tools;
  console_bridge::noOutputHandler();  // the faults of a bag are in its line
  try {
    const std::optional<Arguments> arguments = parse(argc, argv);
    if (!arguments) return EXIT_SUCCESS;
    if (!arguments->merge.empty()) {
      merge(*arguments);
      return EXIT_SUCCESS;
    }
    return run(*arguments) == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "identify_batch: %s\n", error.what());
    return EXIT_FAILURE;
  }
}
