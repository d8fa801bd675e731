// rosrun ring_gyro identify: from recorded runs to parameters with their uncertainties.

#include <console_bridge/console.h>

#include <algorithm>
#include <atomic>
#include <boost/program_options.hpp>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "command_line.h"
#include "device_options.h"
#include "progress_bar.h"
#include "ring_gyro/common/formatted.h"
#include "ring_gyro/common/output_target.h"
#include "ring_gyro/common/parallel_for.h"
#include "ring_gyro/common/whole_file.h"
#include "ring_gyro/identification/filter/extended_identifier.h"
#include "ring_gyro/ros/bag_identification.h"
#include "ring_gyro/ros/bag_writer.h"
#include "ring_gyro/ros/conversions.h"
#include "ring_gyro/ros/recorded_run.h"
#include "ring_gyro/ros/topics.h"

namespace ring_gyro::tools {
namespace {

namespace options = boost::program_options;

constexpr int kIdentified = 0;
constexpr int kFailed = 1;
constexpr int kIdentifiedWithFaults = 2;
constexpr char kExitText[] =
    "\nExit status: 0 identified; 2 identified, but data was lost or unusable, or does not fit the "
    "model (lines on stderr); "
    "1 at least one run could not be identified.\n";

struct Arguments {
  std::vector<std::string> bags;
  DeviceOptions device;
  std::string json_file;
  std::string estimates_file;
  bool as_one_run = false;
  bool extended = false;
  bridge::BagIdentificationOptions identification;
};

/// Result of one run.
struct Outcome {
  std::optional<bridge::IdentificationResult> result;
  std::string error;
};

/// Empty when the program has already printed what was requested (--help).
std::optional<Arguments> parse(int argc, char** argv) {
  Arguments arguments;
  double duration = 0.0;
  options::options_description description("identify");
  arguments.device.addTo(description);
  description.add_options()("help,h", "this text")("bag", options::value(&arguments.bags),
                                                   "recorded runs (or just their names)")(
      "json", options::value(&arguments.json_file), "file for the results, SI units")(
      "estimates", options::value(&arguments.estimates_file),
      "bag for every estimate on the way, as the node publishes them")(
      "start", options::value(&arguments.identification.start),
      "what lies before is left out, bag time from the begin [s]")(
      "duration", options::value(&duration), "of what is used, from --start on [s]")(
      "start-sequence", options::value(&arguments.identification.start_sequence),
      "the filter starts with this block, as an identifier that was started there")(
      "continue", options::bool_switch(&arguments.as_one_run),
      "the bags are one run that was split")(
      "extended", options::bool_switch(&arguments.extended),
      "print the estimates of the extended identifier too, by the section extended")(
      "elements", options::value(&arguments.identification.topics.elements),
      "topic of the orbital elements, when there are several")(
      "gains", options::value(&arguments.identification.topics.gains),
      "topic of the control gains, when there are several");
  const options::variables_map values = parseCommandLine(argc, argv, description, "bag");
  if (values.count("help") != 0) {
    std::cout << "usage: identify RUN.bag [MORE.bag ...] --config FILE | --preset NAME\n"
              << description << kExitText;
    return std::nullopt;
  }
  if (arguments.bags.empty()) throw options::error("no bag given; see identify --help");
  if (!(arguments.identification.start >= 0.0))
    throw options::error("--start must be at least 0 s");
  if (values.count("duration") != 0) {
    if (!(duration > 0.0)) throw options::error("--duration must be above 0 s");
    arguments.identification.duration = duration;
  }
  if (!arguments.estimates_file.empty() && arguments.bags.size() > 1 && !arguments.as_one_run) {
    throw options::error("--estimates is for one run; give one bag, or --continue");
  }
  return arguments;
}

/// Writes every estimate as the node publishes it.
class EstimateRecorder {
 public:
  explicit EstimateRecorder(const std::string& path) : writer_(path) {}
  void write(const cvg::ParameterEstimate& estimate) {
    bridge::toMessage(estimate, message_);
    writer_.write(bridge::topics::kParameterEstimate, message_);
  }
  void finish() { writer_.finish(); }

 private:
  bridge::BagWriter writer_;
  ring_gyro::ParameterEstimate message_;
};

/// All the runs, independently, on as many threads as there are cores.
class Identification {
 public:
  Identification(const Arguments& arguments, const cvg::LoopConfiguration& configuration)
      : arguments_(arguments), configuration_(configuration) {
    if (arguments.as_one_run) {
      runs_.push_back(arguments.bags);
    } else {
      for (const std::string& bag : arguments.bags) runs_.push_back({bag});
    }
    outcomes_.resize(runs_.size());
    progress_ = std::vector<Progress>(runs_.size());
  }

  const std::vector<Outcome>& run() {
    std::thread progress([this] { showProgress(); });
    cvg::parallelFor(runs_.size(), cvg::coreCount(), [this](std::size_t run) { work(run); });
    progress.join();
    return outcomes_;
  }

 private:
  struct Progress {
    Progress() = default;
    Progress(const Progress& /*other*/) {}  // for the vector, before it is used
    std::atomic<double> length{0.0};
    std::atomic<double> done{0.0};
  };

  void work(std::size_t run) {
    try {
      outcomes_[run].result = identify(runs_[run], progress_[run]);
    } catch (const std::exception& error) {
      outcomes_[run].error = error.what();
    }
    const std::lock_guard<std::mutex> lock(mutex_);
    ++finished_;
    finished_changed_.notify_one();
  }

  bridge::IdentificationResult identify(const std::vector<std::string>& bags,
                                        Progress& progress) const {
    bridge::BagIdentification identification(bags, configuration_, arguments_.identification);
    progress.length = identification.length();
    std::unique_ptr<EstimateRecorder> recorder;
    bridge::BagIdentification::OnEstimate on_estimate;
    if (!arguments_.estimates_file.empty()) {
      recorder = std::make_unique<EstimateRecorder>(arguments_.estimates_file);
      on_estimate = [&recorder](const cvg::ParameterEstimate& estimate) {
        recorder->write(estimate);
      };
    }
    bridge::IdentificationResult result =
        identification.run(on_estimate, [&progress](double done) { progress.done = done; });
    if (recorder) recorder->finish();
    return result;
  }

  void showProgress() {
    ProgressBar bar(0.0);
    std::unique_lock<std::mutex> lock(mutex_);
    while (!finished_changed_.wait_for(lock, std::chrono::milliseconds(100),
                                       [this] { return finished_ == runs_.size(); })) {
      double length = 0.0;
      double done = 0.0;
      for (const Progress& progress : progress_) {
        length += progress.length;
        done += progress.done;
      }
      bar.setTotal(length);
      bar.showNow(done);
    }
  }

  const Arguments& arguments_;
  const cvg::LoopConfiguration& configuration_;
  std::vector<std::vector<std::string>> runs_;
  std::vector<Outcome> outcomes_;
  std::vector<Progress> progress_;
  std::mutex mutex_;
  std::condition_variable finished_changed_;
  std::size_t finished_ = 0;
};

struct ExtendedReport {
  std::string text;    // a printed table
  std::string misfit;  // as NisTally::misfit()
};

/// The extended identifier over the same run.
ExtendedReport extendedReport(const std::vector<std::string>& bags, const Arguments& arguments,
                              const cvg::LoopConfiguration& configuration) {
  const bridge::BagIdentificationOptions& wanted = arguments.identification;
  const bridge::RecordedRun run =
      bridge::readRecordedRun(bags, wanted.topics, wanted.start, wanted.duration.value_or(0.0));
  cvg::ExtendedIdentifier identifier(configuration.device, configuration.extended,
                                     configuration.converter);
  cvg::ExtendedEstimate last;
  cvg::NisTally nis;
  for (const bridge::RecordedPair& pair : run.pairs) {
    if (pair.elements.stamp.sequence < wanted.start_sequence) continue;
    const auto estimate = identifier.process(
        pair.elements, pair.gains, configuration.device.angular_gain * pair.rotation_rate);
    if (!estimate) continue;
    last = *estimate;
    if (!last.updated || !last.whole_period) continue;
    nis.add(last.normalised_innovation_squared, last.settled);
  }
  if (!last.scaled) {
    return {"  extended     not identified: no complete period of usable blocks\n", ""};
  }
  std::string text;
  const std::string misfit = nis.misfit(4);
  const std::uint64_t updates = nis.updates_converged;
  text += cvg::formatted("  extended     %s, Q %.8g, mean NIS %.3f of 4 over %llu updates\n",
                         !misfit.empty() ? "does not fit"
                         : last.settled  ? "settled"
                                         : "the cubic term is not found yet",
                         last.quality_factor,
                         updates > 0 ? nis.sum_converged / static_cast<double>(updates) : 0.0,
                         static_cast<unsigned long long>(updates));
  for (std::size_t k = 4; k < identifier.names().size(); ++k) {
    const auto state = static_cast<Eigen::Index>(k);
    text += cvg::formatted("    %-21s %20.13g +- %.2g\n", identifier.names()[k].c_str(),
                           last.value[state], last.sigma(state));
  }
  return {text, misfit};
}

/// Tables, lines about faults, JSON. Returns the exit status.
int report(const std::vector<Outcome>& outcomes, const Arguments& arguments,
           const cvg::LoopConfiguration& configuration, cvg::WholeFile& json) {
  std::vector<bridge::IdentificationResult> results;
  bool failed = false;
  bool faulty = false;
  const auto say = [](const std::string& source, const std::string& line) {
    std::fprintf(stderr, "%s: %s\n", source.c_str(), line.c_str());
  };
  for (const Outcome& outcome : outcomes) {
    if (!outcome.result) {
      std::fprintf(stderr, "%s\n", outcome.error.c_str());
      failed = true;
      continue;
    }
    const bridge::IdentificationResult& result = *outcome.result;
    const std::string& source = result.sources.front();
    std::fputs(bridge::identificationText(result, configuration).c_str(), stdout);
    if (arguments.extended) {
      const ExtendedReport extended = extendedReport(result.sources, arguments, configuration);
      std::fputs(extended.text.c_str(), stdout);
      if (!extended.misfit.empty()) say(source, "extended: " + extended.misfit);
      faulty = faulty || !extended.misfit.empty();
    }
    std::fflush(stdout);
    for (const std::string& line : result.damage) say(source, line);
    const bridge::Verdict verdict = bridge::verdictOf(result, configuration);
    if (verdict == bridge::Verdict::kFailed) {
      say(source, bridge::failureOf(result.report, configuration));
      failed = true;
    } else {
      for (const std::string& line : bridge::faultsOf(result.report, configuration)) {
        say(source, line);
      }
      faulty = faulty || verdict == bridge::Verdict::kIdentifiedWithFaults;
    }
    results.push_back(result);
  }
  if (!results.empty()) json.finish(bridge::identificationJson(results, configuration));
  return failed ? kFailed : faulty ? kIdentifiedWithFaults : kIdentified;
}

}  // namespace
}  // namespace ring_gyro::tools

int main(int argc, char** argv) {
  using namespace ring_gyro::tools;
  console_bridge::noOutputHandler();  // faults are reported once, here
  try {
    const std::optional<Arguments> arguments = parse(argc, argv);
    if (!arguments) return EXIT_SUCCESS;
    const cvg::LoopConfiguration configuration = arguments->device.read();
    std::vector<std::string> inputs = arguments->bags;
    inputs.insert(inputs.end(), configuration.files.begin(), configuration.files.end());
    cvg::requireApart({arguments->json_file, arguments->estimates_file}, inputs);
    cvg::WholeFile json(arguments->json_file);
    Identification identification(*arguments, configuration);
    return report(identification.run(), *arguments, configuration, json);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "identify: %s\n", error.what());
    return kFailed;
  }
}
