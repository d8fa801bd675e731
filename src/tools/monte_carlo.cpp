// rosrun ring_gyro monte_carlo: many closed-loop runs, one JSON line each, on all cores.

#include "ring_gyro/simulation/monte_carlo.h"

#include <boost/program_options.hpp>
#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "command_line.h"
#include "line_batch.h"
#include "progress_bar.h"
#include "ring_gyro/common/formatted.h"
#include "ring_gyro/common/output_target.h"
#include "ring_gyro/common/parallel_for.h"
#include "ring_gyro/configuration/configuration_reader.h"

namespace ring_gyro::tools {
namespace {

namespace options = boost::program_options;
using Json = nlohmann::ordered_json;

struct Arguments {
  std::string configuration_file;
  std::vector<std::string> overrides;
  bool random_devices = false;
  cvg::ItemRange range;
  unsigned threads = 0;
  std::string output;
  bool resume = false;
  std::vector<std::string> merge;
};

/// Empty when the program has already printed what was requested (--help).
std::optional<Arguments> parse(int argc, char** argv) {
  Arguments arguments;
  std::string shard;
  options::options_description description("monte_carlo");
  description.add_options()("help,h", "this text")(
      "config,c", options::value(&arguments.configuration_file), "YAML file of the configuration")(
      "set", options::value(&arguments.overrides)->composing(),
      "section/key=value, in place of what the file says; may be repeated")(
      "random-devices", options::bool_switch(&arguments.random_devices),
      "each item has a device of its own, drawn by its index (docs/batch.md)")(
      "first", options::value(&arguments.range.first),
      "index of the first item; the seed is run/seed + index")(
      "count", options::value(&arguments.range.count), "number of items")(
      "shard", options::value(&shard), "K/N: of these items only those with index % N = K")(
      "threads", options::value(&arguments.threads), "0: all cores")(
      "output,o", options::value(&arguments.output), "file to which a JSON line is added per item")(
      "resume", options::bool_switch(&arguments.resume),
      "leave out what the output file already holds; a line that was cut short is done again")(
      "merge", options::value(&arguments.merge)->multitoken(),
      "instead of running: joins these files by index, without duplicates, into --output if given, "
      "and prints the statistics");
  const options::variables_map values = parseCommandLine(argc, argv, description);
  if (values.count("help") != 0) {
    std::cout << "usage: monte_carlo --config FILE --count N --output FILE [--shard K/N] "
                 "[--resume]\n       monte_carlo --merge FILE ... [--output FILE]\n"
              << description;
    return std::nullopt;
  }
  if (!arguments.merge.empty()) return arguments;
  if (arguments.configuration_file.empty()) throw options::error("--config FILE is missing");
  if (arguments.output.empty()) throw options::error("--output FILE is missing");
  if (arguments.range.count == 0) throw options::error("--count N is missing, or zero");
  setShard(shard, arguments.range);
  return arguments;
}

/// Identifies batches that must not be mixed: FNV-1a of every parameter except the seed's index.
std::string fingerprint(const cvg::MonteCarlo& batch) {
  std::ostringstream text;
  text.precision(17);
  text << batch.random_devices;
  cvg::LoopConfiguration configuration = batch.configuration;
  for (const cvg::Section& section : configuration.sections()) {
    for (const cvg::Parameter& parameter : section.table.parameters()) {
      text << '\n' << section.name << '/' << parameter.key << '=';
      std::visit(
          [&text](const auto& target) {
            using Target = std::decay_t<decltype(*target)>;
            if constexpr (std::is_same_v<Target, std::vector<double>>) {
              for (const double value : *target) text << value << ' ';
            } else {
              text << *target;
            }
          },
          parameter.target);
    }
  }
  std::uint64_t hash = 14695981039346656037u;
  for (const char c : text.str()) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211u;
  return cvg::formatted("%016" PRIx64, hash);
}

Json byName(const std::array<double, 5>& values) {
  Json json;
  for (std::size_t k = 0; k < values.size(); ++k) json[cvg::kMonteCarloParameters[k]] = values[k];
  return json;
}

/// JSON has no NaN: it is written as null.
double numberOf(const Json& json) {
  return json.is_null() ? std::numeric_limits<double>::quiet_NaN() : json.get<double>();
}

std::array<double, 5> byName(const Json& json) {
  std::array<double, 5> values{};
  for (std::size_t k = 0; k < values.size(); ++k) {
    values[k] = numberOf(json.at(cvg::kMonteCarloParameters[k]));
  }
  return values;
}

std::string lineOf(const cvg::MonteCarloItem& item, const std::string& batch) {
  Json json;
  json["index"] = item.index;
  json["batch"] = batch;
  json["seed"] = item.seed;
  if (!item.refused.empty()) {
    json["refused"] = item.refused;
    return asLine(json);
  }
  json["natural_frequency"] = item.natural_frequency;
  json["quality_factor"] = item.quality_factor;
  json["virtual_rate"] = item.virtual_rate;
  json["duration"] = item.duration;
  json["locked_after"] = item.locked_after;
  json["converged"] = item.converged;
  json["used_blocks"] = item.used_blocks;
  json["rejected_blocks"] = item.rejected_blocks;
  json["truth"] = byName(item.truth);
  json["estimate"] = byName(item.estimate);
  json["sigma"] = byName(item.sigma);
  json["updates"] = item.updates;
  json["mean_normalised_innovation_squared"] = item.mean_normalised_innovation_squared;
  return asLine(json);
}

cvg::MonteCarloItem itemOf(const Json& json) {
  cvg::MonteCarloItem item;
  item.index = json.at("index");
  item.seed = json.at("seed");
  if (json.contains("refused")) {
    item.refused = json.at("refused").get<std::string>();
    return item;
  }
  item.converged = json.at("converged");
  item.truth = byName(json.at("truth"));
  item.estimate = byName(json.at("estimate"));
  item.sigma = byName(json.at("sigma"));
  item.updates = json.at("updates");
  item.mean_normalised_innovation_squared = numberOf(json.at("mean_normalised_innovation_squared"));
  return item;
}

/// Checks that all lines have the fingerprint of one configuration: `of`, or that of the first
/// line.
LineCheck checkOf(const std::string& of = "") {
  return [batch = of](std::uint64_t /*index*/, const Json& json) mutable {
    itemOf(json);
    const std::string mark = json.at("batch");
    if (batch.empty()) batch = mark;
    if (mark == batch) return;
    throw std::runtime_error(
        "of another configuration than the lines before or the present one; give each batch files "
        "of its own");
  };
}

void print(const cvg::MonteCarloSummary& summary) {
  std::printf("items      %" PRIu64 ", %" PRIu64 " refused, %" PRIu64 " converged\n", summary.items,
              summary.refused, summary.converged);
  if (summary.items == summary.refused) return;
  std::printf("parameter    mean error         RMSE   mean sigma   in 95 %% interval\n");
  for (std::size_t k = 0; k < summary.parameters.size(); ++k) {
    const cvg::ParameterStatistics& p = summary.parameters[k];
    std::printf("%-10s % 12.3e %12.3e %12.3e %12.1f %%%s\n", cvg::kMonteCarloParameters[k],
                p.mean_error, p.root_mean_square_error, p.mean_sigma, 100.0 * p.coverage,
                k + 1 == summary.parameters.size() ? " (relative)" : "");
  }
  std::printf("innovations  mean normalised square %.4f, expected 2\n",
              summary.mean_normalised_innovation_squared);
}

void printReasons(const std::vector<cvg::MonteCarloItem>& items) {
  std::map<std::string, int> reasons;
  for (const cvg::MonteCarloItem& item : items) {
    if (!item.refused.empty()) ++reasons[item.refused];
  }
  for (const auto& reason : reasons) {
    std::printf("refused    %d: %s\n", reason.second, reason.first.c_str());
  }
}

void printStatistics(const LinesByIndex& lines) {
  std::vector<cvg::MonteCarloItem> items;
  for (const auto& line : lines) items.push_back(itemOf(Json::parse(line.second)));
  print(summarise(items));
  printReasons(items);
}

void runBatch(const Arguments& arguments) {
  cvg::MonteCarlo batch;
  batch.configuration =
      cvg::readConfigurationFile(arguments.configuration_file, arguments.overrides);
  batch.random_devices = arguments.random_devices;
  const std::string name = fingerprint(batch);

  cvg::requireApart({arguments.output}, batch.configuration.files);
  LineBatch file("monte_carlo", arguments.output, arguments.resume, checkOf(name));
  const std::vector<std::uint64_t> left = file.left(arguments.range);
  const std::size_t threads = arguments.threads != 0 ? arguments.threads : cvg::coreCount();
  ProgressBar progress(static_cast<double>(left.size()), "items");
  double done = 0.0;
  cvg::runMonteCarlo(batch, left, threads, [&](const cvg::MonteCarloItem& item) {
    file.add(item.index, lineOf(item, name));
    progress.showNow(done += 1.0);
  });
  file.finish();
  printStatistics(file.lines());
}

}  // namespace
}  // namespace ring_gyro::tools

int main(int argc, char** argv) {
  using namespace ring_gyro::tools;
  try {
    const std::optional<Arguments> arguments = parse(argc, argv);
    if (!arguments) return EXIT_SUCCESS;
    if (arguments->merge.empty()) {
      runBatch(*arguments);
    } else {
      printStatistics(mergeLines("monte_carlo", arguments->merge, arguments->output, checkOf()));
    }
    return EXIT_SUCCESS;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "monte_carlo: %s\n", error.what());
    return EXIT_FAILURE;
  }
}
