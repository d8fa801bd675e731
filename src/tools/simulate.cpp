// rosrun ring_gyro simulate: the whole loop in this process; writes the same bag as the graph.

#include <boost/program_options.hpp>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

#include "command_line.h"
#include "configuration_options.h"
#include "progress_bar.h"
#include "ring_gyro/common/angle.h"
#include "ring_gyro/common/output_target.h"
#include "ring_gyro/configuration/configuration_reader.h"
#include "ring_gyro/identification/judge/consistency.h"
#include "ring_gyro/ros/loop_recorder.h"
#include "ring_gyro/signals/compensation_decision.h"
#include "ring_gyro/simulation/closed_loop.h"

namespace ring_gyro::tools {
namespace {

namespace options = boost::program_options;

volatile std::sig_atomic_t interrupted = 0;  // a type that a signal handler may write

struct Arguments {
  ConfigurationOptions configuration;
  std::string duration;
  std::string output_file;
  bool raw = false;
};

struct Summary {
  cvg::BlockStamp last;
  double simulated = 0.0;              // [s]
  double wall = 0.0;                   // [s]
  std::optional<double> locked_after;  // [s]
  std::optional<cvg::ParameterEstimate> estimate;
  cvg::NisTally nis;
  bool converged = false;  // according to the identifier
  std::optional<cvg::CompensationDecision> decision;
  cvg::OrbitalElements elements;
  std::uint64_t messages = 0;
};

/// Empty when the program has already printed what was requested (--help, --parameters).
std::optional<Arguments> parse(int argc, char** argv) {
  Arguments arguments;
  options::options_description description("simulate");
  arguments.configuration.addTo(description);
  description.add_options()("help,h", "this text")(
      "output,o", options::value(&arguments.output_file), "bag to write")(
      "duration", options::value(&arguments.duration), "of the run [s], instead of run/duration")(
      "raw", options::bool_switch(&arguments.raw), "record samples and drive commands too")(
      "parameters", "print the reference of all parameters (Markdown)");
  const options::variables_map values = parseCommandLine(argc, argv, description);
  if (values.count("help") != 0) {
    std::cout << "usage: simulate --config FILE [--output BAG] [--set section/key=value ...]\n"
              << description;
    return std::nullopt;
  }
  if (values.count("parameters") != 0) {
    std::cout << cvg::parametersMarkdown();
    return std::nullopt;
  }
  return arguments;
}

void take(const cvg::ParameterEstimate& estimate, Summary& summary) {
  summary.estimate = estimate;
  if (estimate.updated) {
    summary.nis.add(estimate.normalised_innovation_squared, summary.converged);
  }
  summary.converged = summary.converged || estimate.converged;
}

Summary simulate(const cvg::LoopConfiguration& configuration, const Arguments& arguments) {
  cvg::requireApart({arguments.output_file}, configuration.files);
  cvg::ClosedLoop loop(configuration);
  std::optional<bridge::LoopRecorder> recorder;
  if (!arguments.output_file.empty()) recorder.emplace(arguments.output_file, arguments.raw);
  std::signal(SIGINT, [](int) { interrupted = 1; });
  std::signal(SIGTERM, [](int) { interrupted = 1; });
  const std::uint64_t blocks = configuration.run.blocks(configuration.converter);
  ProgressBar progress(configuration.run.duration);
  Summary summary;
  const auto begin = std::chrono::steady_clock::now();
  for (std::uint64_t block = 0; (blocks == 0 || block < blocks) && interrupted == 0; ++block) {
    const cvg::LoopRecord record = loop.step();
    if (recorder) recorder->write(record);
    if (record.estimate) take(*record.estimate, summary);
    if (record.decision) summary.decision = *record.decision;
    if (!summary.locked_after && record.loops.elements.status.locked()) {
      summary.locked_after = loop.time();
    }
    summary.last = record.displacement.stamp;
    summary.elements = record.loops.elements;
    progress.show(loop.time());
  }
  if (recorder) {
    recorder->finish(summary.last, blocks != 0 && summary.last.sequence + 1 < blocks);
    summary.messages = recorder->messages();
  }
  summary.simulated = loop.time();
  summary.wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return summary;
}

void print(const Summary& summary, const cvg::LoopConfiguration& configuration,
           const Arguments& arguments) {
  std::printf("simulated  %.3f s in %.2f s, %.1f times real time%s\n", summary.simulated,
              summary.wall, summary.simulated / summary.wall,
              interrupted != 0 ? " (interrupted)" : "");
  if (summary.locked_after) {
    std::printf("locked     after %.3f s; at the end a %.5f V, pattern at %.4f deg/s\n",
                *summary.locked_after, summary.elements.orbit.a,
                cvg::toDegrees(summary.elements.theta_rate));
  } else {
    std::printf("locked     never\n");
  }
  if (summary.estimate) {
    const cvg::StateVector& value = summary.estimate->value;
    const cvg::ResonatorParameters& truth = configuration.plant.resonator;
    const auto line = [&](const char* name, cvg::StateIndex index, double true_value) {
      std::printf("%-10s % .6e +- %.1e, true % .6e\n", name, value[index],
                  summary.estimate->sigma(index), true_value);
    };
    line("gamma1", cvg::kGamma1, truth.gamma1);
    line("gamma2", cvg::kGamma2, truth.gamma2);
    line("mu1", cvg::kMu1, truth.mu1);
    line("mu2", cvg::kMu2, truth.mu2);
    line("ks", cvg::kDriveGain, truth.driveGain());
    std::printf("estimate   %s, %lu blocks used, %lu rejected, %lu lost\n",
                !summary.nis.misfit().empty() ? "does not fit the data"
                : summary.estimate->converged ? "converged"
                                              : "not converged",
                static_cast<unsigned long>(summary.estimate->used_blocks),
                static_cast<unsigned long>(summary.estimate->rejected_blocks),
                static_cast<unsigned long>(summary.estimate->lost_blocks));
  }
  if (summary.decision && configuration.control.compensation) {
    std::printf("injector   %s, cancels gamma (%.6f, %.6f)\n",
                cvg::toString(summary.decision->state), summary.decision->gamma1,
                summary.decision->gamma2);
  }
  if (!arguments.output_file.empty()) {
    std::printf("recorded   %lu messages in %s\n", static_cast<unsigned long>(summary.messages),
                arguments.output_file.c_str());
  }
}

}  // namespace
}  // namespace ring_gyro::tools

int main(int argc, char** argv) {
  using namespace ring_gyro::tools;
  try {
    const std::optional<Arguments> arguments = parse(argc, argv);
    if (!arguments) return EXIT_SUCCESS;
    std::vector<std::string> overrides;
    if (!arguments->duration.empty()) overrides.push_back("run/duration=" + arguments->duration);
    const cvg::LoopConfiguration configuration = arguments->configuration.read(overrides);
    print(simulate(configuration, *arguments), configuration, *arguments);
    return EXIT_SUCCESS;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return EXIT_FAILURE;
  }
}
