// rosrun ring_gyro compare_identifiers: the same recorded runs through every identifier of the
// package, from good and from bad first guesses.

#include <console_bridge/console.h>

#include <algorithm>
#include <array>
#include <boost/program_options.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <functional>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

#include "command_line.h"
#include "device_options.h"
#include "ring_gyro/common/angle.h"
#include "ring_gyro/common/formatted.h"
#include "ring_gyro/identification/filter/extended_identifier.h"
#include "ring_gyro/identification/filter/identifier.h"
#include "ring_gyro/identification/judge/batch_least_squares.h"
#include "ring_gyro/ros/recorded_run.h"

namespace ring_gyro::tools {
namespace {

namespace options = boost::program_options;

constexpr char kNotes[] =
    "\nStarts: `as told` takes Q from the configuration and ks from the balance of the first "
    "period; "
    "`Q 1.5x` tells a Q that much too high; `ks 10x, -gamma` begins at ten times the ks of the "
    "loops "
    "and at the true gamma (or 0.02) with the wrong sign. The seven-state filters always take ks "
    "from "
    "the balance.\n"
    "Errors are against the truth in the bag, `-` without; sigma is the filter's own.\n";

struct Arguments {
  std::vector<std::string> bags;
  DeviceOptions device;
  double duration = 0.0;
};

/// Empty when the program has already printed what was requested (--help).
std::optional<Arguments> parse(int argc, char** argv) {
  Arguments arguments;
  options::options_description description("compare_identifiers");
  arguments.device.addTo(description);
  description.add_options()("help,h", "this text")("bag", options::value(&arguments.bags),
                                                   "recorded runs (or just their names)")(
      "duration", options::value(&arguments.duration), "of what is used; 0: all [s]");
  const options::variables_map values = parseCommandLine(argc, argv, description, "bag");
  if (values.count("help") != 0) {
    std::cout << "usage: compare_identifiers RUN.bag [MORE.bag ...] --config FILE | --preset NAME\n"
              << description << kNotes;
    return std::nullopt;
  }
  if (arguments.bags.empty()) throw options::error("no bag given; see compare_identifiers --help");
  if (!(arguments.duration >= 0.0)) throw options::error("--duration must be at least 0 s");
  return arguments;
}

using Pair = bridge::RecordedPair;

/// gamma1, gamma2, mu1, mu2, ks, Q.
using Figures = std::array<double, 6>;

struct Estimate {
  bool found = false;
  Figures value{};
  Figures sigma{};
};

struct Method {
  std::string name;
  std::string start;
  std::function<Estimate(const std::vector<Pair>&)> run;
};

Estimate runSevenStates(const cvg::DeviceKnowledge& device,
                        const cvg::IdentificationParameters& parameters,
                        const cvg::ConverterParameters& converter, const std::vector<Pair>& pairs) {
  cvg::Identifier identifier(device, parameters, converter);
  Estimate result;
  for (const Pair& pair : pairs) {
    const auto estimate = identifier.process(pair.elements, pair.gains);
    if (!estimate || !estimate->updated) continue;
    result.found = true;
    for (int k = 0; k < 5; ++k) {
      const auto state = static_cast<cvg::StateIndex>(cvg::kGamma1 + k);
      result.value[static_cast<std::size_t>(k)] = estimate->value[state];
      result.sigma[static_cast<std::size_t>(k)] = estimate->sigma(state);
    }
  }
  result.value[5] = device.quality_factor;
  return result;
}

Estimate figuresOf(const cvg::ExtendedState& state, const cvg::ExtendedVector& value,
                   const cvg::ExtendedMatrix& covariance) {
  Estimate result;
  result.found = true;
  for (Eigen::Index k = 0; k < 5; ++k) {
    result.value[static_cast<std::size_t>(k)] = value[4 + k];
    result.sigma[static_cast<std::size_t>(k)] = std::sqrt(covariance(4 + k, 4 + k));
  }
  const int at = state.layout().decay_rate;
  result.value[5] = state.device().quality_factor;
  if (at >= 0) {
    const int frequency_at = state.layout().frequency;
    const double w0 =
        frequency_at < 0 ? state.device().angularFrequency() : cvg::kTwoPi * value[frequency_at];
    result.value[5] = 0.5 * w0 / value[at];
    result.sigma[5] = result.value[5] * std::sqrt(covariance(at, at)) / value[at];
  }
  return result;
}

Estimate runExtended(const cvg::DeviceKnowledge& device, const cvg::ExtendedParameters& parameters,
                     const cvg::ConverterParameters& converter, const std::vector<Pair>& pairs) {
  cvg::ExtendedIdentifier identifier(device, parameters, converter);
  std::optional<cvg::ExtendedEstimate> last;
  for (const Pair& pair : pairs) {
    auto estimate =
        identifier.process(pair.elements, pair.gains, device.angular_gain * pair.rotation_rate);
    if (estimate && estimate->scaled) last = estimate;
  }
  if (!last) return {};
  return figuresOf(cvg::ExtendedState(device, parameters), last->value, last->covariance);
}

Estimate runBatch(const cvg::DeviceKnowledge& device, const cvg::ExtendedParameters& parameters,
                  const cvg::ConverterParameters& converter, const std::vector<Pair>& pairs) {
  cvg::BatchLeastSquares fit(device, parameters, converter);
  for (const Pair& pair : pairs) {
    fit.add(pair.elements, pair.gains, device.angular_gain * pair.rotation_rate);
  }
  const cvg::BatchEstimate estimate = fit.solve();
  if (!estimate.converged) return {};
  return figuresOf(cvg::ExtendedState(device, parameters), estimate.value, estimate.covariance);
}

std::vector<Method> methods(const cvg::LoopConfiguration& configuration,
                            const std::optional<cvg::PlantTruth>& truth) {
  const cvg::ConverterParameters& converter = configuration.converter;
  std::vector<Method> result;
  for (const double quality : {1.0, 1.5}) {
    const std::string start = quality == 1.0 ? "as told" : "Q 1.5x";
    for (const cvg::Tuning tuning : {cvg::Tuning::kPaper, cvg::Tuning::kDerived}) {
      cvg::IdentificationParameters parameters = configuration.identification;
      parameters.tuning = tuning;
      cvg::DeviceKnowledge device = configuration.device;
      device.quality_factor *= quality;
      result.push_back(
          {std::string("EKF, ") + (tuning == cvg::Tuning::kPaper ? "paper" : "derived"), start,
           [=](const std::vector<Pair>& pairs) {
             return runSevenStates(device, parameters, converter, pairs);
           }});
    }
  }
  for (const std::string start : {"as told", "Q 1.5x", "ks 10x, -gamma"}) {
    cvg::ExtendedParameters parameters = configuration.extended;
    cvg::DeviceKnowledge device = configuration.device;
    if (start == "Q 1.5x") device.quality_factor *= 1.5;
    if (start == "ks 10x, -gamma") {
      parameters.initial_drive_gain = 10.0 * configuration.device.drive_gain;
      parameters.initial_drive_gain_sigma = 1.0;
      parameters.initial_gamma1 = truth ? -truth->gamma1 : -0.02;
      parameters.initial_gamma2 = truth ? -truth->gamma2 : -0.02;
    }
    result.push_back({"extended filter", start, [=](const std::vector<Pair>& pairs) {
                        return runExtended(device, parameters, converter, pairs);
                      }});
    result.push_back({"least squares", start, [=](const std::vector<Pair>& pairs) {
                        return runBatch(device, parameters, converter, pairs);
                      }});
  }
  return result;
}

/// Magnitudes of the errors for comparison: gamma, mu, relative ks, relative Q.
using Sizes = std::array<double, 4>;

Sizes sizes(const Figures& figures, double drive_gain, double quality) {
  return {std::hypot(figures[0], figures[1]), std::hypot(figures[2], figures[3]),
          std::abs(figures[4] / drive_gain), std::abs(figures[5] / quality)};
}

struct Row {
  std::string name;
  std::string start;
  bool found = false;
  std::optional<Sizes> error;
  Sizes sigma{};
  double seconds = 0.0;
};

std::string cell(bool known, double value) {
  if (!known) return "-";
  return cvg::formatted("%.1e", value);
}

void print(const std::vector<Row>& rows) {
  std::printf("%-16s %-14s | %-17s | %-17s | %-17s | %-17s | %7s\n", "", "", "gamma", "mu",
              "ks, relative", "Q, relative", "time");
  std::printf("%-16s %-14s | %8s %8s | %8s %8s | %8s %8s | %8s %8s | %7s\n", "identifier", "start",
              "error", "sigma", "error", "sigma", "error", "sigma", "error", "sigma", "s");
  for (const Row& row : rows) {
    std::printf("%-16s %-14s |", row.name.c_str(), row.start.c_str());
    for (std::size_t k = 0; k < 4; ++k) {
      const bool known = row.found && row.error.has_value();
      std::printf(" %8s %8s |", cell(known, known ? (*row.error)[k] : 0.0).c_str(),
                  cell(row.found && row.sigma[k] > 0.0, row.sigma[k]).c_str());
    }
    std::printf(" %7.2f\n", row.seconds);
  }
}

std::vector<Row> compare(const bridge::RecordedRun& run,
                         const cvg::LoopConfiguration& configuration) {
  std::vector<Row> rows;
  for (const Method& method : methods(configuration, run.truth)) {
    Row row{method.name, method.start, false, std::nullopt, {}, 0.0};
    const auto begin = std::chrono::steady_clock::now();
    const Estimate estimate = method.run(run.pairs);
    row.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    row.found = estimate.found;
    if (estimate.found) {
      row.sigma = sizes(estimate.sigma, estimate.value[4], estimate.value[5]);
      if (run.truth) {
        const cvg::PlantTruth& truth = *run.truth;
        const Figures right{truth.gamma1, truth.gamma2,     truth.mu1,
                            truth.mu2,    truth.drive_gain, truth.quality_factor};
        Figures error;
        for (std::size_t k = 0; k < 6; ++k) error[k] = estimate.value[k] - right[k];
        row.error = sizes(error, truth.drive_gain, truth.quality_factor);
      }
    }
    rows.push_back(row);
  }
  return rows;
}

/// Root mean squares over the runs that have a result; for the time, the mean.
std::vector<Row> summarise(const std::vector<std::vector<Row>>& runs) {
  std::vector<Row> result = runs.front();
  for (std::size_t r = 0; r < result.size(); ++r) {
    Row& row = result[r];
    Sizes error{};
    Sizes sigma{};
    int errors = 0;
    int found = 0;
    row.seconds = 0.0;
    for (const std::vector<Row>& run : runs) {
      row.seconds += run[r].seconds / static_cast<double>(runs.size());
      if (!run[r].found) continue;
      ++found;
      for (std::size_t k = 0; k < 4; ++k) sigma[k] += run[r].sigma[k] * run[r].sigma[k];
      if (!run[r].error) continue;
      ++errors;
      for (std::size_t k = 0; k < 4; ++k) error[k] += (*run[r].error)[k] * (*run[r].error)[k];
    }
    for (std::size_t k = 0; k < 4; ++k) {
      error[k] = std::sqrt(error[k] / std::max(errors, 1));
      sigma[k] = std::sqrt(sigma[k] / std::max(found, 1));
    }
    row.found = found > 0;
    row.sigma = sigma;
    row.error = errors > 0 ? std::optional<Sizes>(error) : std::nullopt;
  }
  return result;
}

int run(const Arguments& arguments) {
  const cvg::LoopConfiguration configuration = arguments.device.read();
  std::vector<std::vector<Row>> runs;
  bool failed = false;
  for (const std::string& path : arguments.bags) {
    try {
      const bridge::RecordedRun recorded =
          bridge::readRecordedRun({path}, {}, 0.0, arguments.duration);
      for (const std::string& damage : recorded.damage) {
        std::fprintf(stderr, "compare_identifiers: %s\n", damage.c_str());
        failed = true;
      }
      runs.push_back(compare(recorded, configuration));
      std::printf("%s: %zu blocks%s\n", path.c_str(), recorded.pairs.size(),
                  recorded.truth ? "" : ", no truth in it");
      print(runs.back());
      std::printf("\n");
    } catch (const std::exception& error) {
      std::fprintf(stderr, "compare_identifiers: %s: %s\n", path.c_str(), error.what());
      failed = true;
    }
  }
  if (runs.size() > 1) {
    std::printf("Root mean square over %zu runs\n", runs.size());
    print(summarise(runs));
  }
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}

}  // namespace
}  // namespace ring_gyro::tools

int main(int argc, char** argv) {
  console_bridge::noOutputHandler();  // faults are reported once, here
  try {
    const auto arguments = ring_gyro::tools::parse(argc, argv);
    return arguments ? ring_gyro::tools::run(*arguments) : EXIT_SUCCESS;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "compare_identifiers: %s\n", error.what());
    return EXIT_FAILURE;
  }
}
