#include "run_report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>

#include "ring_gyro/common/angle.h"
#include "ring_gyro/common/formatted.h"

namespace ring_gyro::tools {
namespace {

void printIdentification(std::string& text, const char* title, bool fits,
                         const std::optional<cvg::IdentificationResult>& result) {
  if (!result) {
    text += cvg::formatted("%s: no estimate\n", title);
    return;
  }
  text +=
      cvg::formatted("%s, at %.1f s: %.1f s of data, %s\n", title, result->time, result->used_time,
                     !fits               ? "does not fit the data"
                     : result->converged ? "converged"
                                         : "not converged");
  text += cvg::formatted("  %-12s %15s %15s %11s %11s\n", "parameter", "truth", "estimate", "sigma",
                         "error");
  for (const cvg::ParameterResult& p : result->parameters) {
    const double scale = p.relative ? std::abs(p.truth) : 1.0;
    text += cvg::formatted("  %-12s % 15.7e % 15.7e %11.1e % 11.1e%s\n", p.name.c_str(), p.truth,
                           p.estimate, p.sigma / scale, p.error() / scale,
                           p.relative ? " (relative)" : "");
  }
}

using DriftValue = double (*)(const cvg::DriftResult&);

void printDriftRow(std::string& text, const char* name, const char* pattern,
                   const cvg::RunSummary& summary, DriftValue value) {
  text += cvg::formatted("  %-38s", name);
  for (const cvg::DriftResult* drift : {&summary.before, &summary.after}) {
    const std::string cell = drift->harmonics ? cvg::formatted(pattern, value(*drift)) : "-";
    text += cvg::formatted(" %13s", cell.c_str());
  }
  text += "\n";
}

template <int harmonic>
double amplitudeInDegrees(const cvg::DriftResult& drift) {
  return cvg::toDegrees(drift.harmonics->amplitude(harmonic));
}

void printDriftTable(std::string& text, const cvg::RunRecord& record,
                     const cvg::RunSummary& summary) {
  text += cvg::formatted("sensed rate against pattern angle%5s %13s %13s\n", "", "before", "after");
  const auto row = [&](const char* name, const char* format, DriftValue value) {
    printDriftRow(text, name, format, summary, value);
  };
  row("from [s]", "%.1f", [](const cvg::DriftResult& d) { return d.harmonics->begin_time; });
  row("to [s]", "%.1f", [](const cvg::DriftResult& d) { return d.harmonics->end_time; });
  row("whole turns", "%.0f",
      [](const cvg::DriftResult& d) { return static_cast<double>(d.harmonics->whole_turns); });
  row("mean [deg/s]", "%.6f",
      [](const cvg::DriftResult& d) { return cvg::toDegrees(-d.harmonics->mean_rate); });
  if (!record.rotated()) {
    row("virtual rate [deg/s]", "%.6f",
        [](const cvg::DriftResult& d) { return cvg::toDegrees(d.virtual_rate); });
    row("mean / virtual rate - 1", "%.2e",
        [](const cvg::DriftResult& d) { return -d.harmonics->mean_rate / d.virtual_rate - 1.0; });
  }
  row("harmonics 1 to 8, peak to peak [deg/s]", "%.5f",
      [](const cvg::DriftResult& d) { return cvg::toDegrees(d.harmonics->peak_to_peak); });
  row("harmonic 1, amplitude [deg/s]", "%.5f", amplitudeInDegrees<1>);
  row("harmonic 2, amplitude [deg/s]", "%.5f", amplitudeInDegrees<2>);
  row("harmonic 4, amplitude [deg/s]", "%.5f", amplitudeInDegrees<4>);
  row("rest about the fit, rms [deg/s]", "%.5f",
      [](const cvg::DriftResult& d) { return cvg::toDegrees(d.harmonics->residual_rms); });
}

void printDrift(std::string& text, const cvg::RunRecord& record, const cvg::RunSummary& summary) {
  if (summary.before.harmonics || summary.after.harmonics) {
    printDriftTable(text, record, summary);
  }
  for (const auto& [name, drift] :
       {std::pair{"before", &summary.before}, std::pair{"after", &summary.after}}) {
    if (!drift->harmonics)
      text += cvg::formatted("no drift %s compensation: %s\n", name, drift->missing.c_str());
  }
}

using Json = nlohmann::ordered_json;

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json jsonOf(const std::optional<cvg::IdentificationResult>& result) {
  if (!result) return nullptr;
  Json parameters = Json::object();
  for (const cvg::ParameterResult& p : result->parameters) {
    parameters[p.name] = {{"truth", number(p.truth)},
                          {"estimate", number(p.estimate)},
                          {"sigma", number(p.sigma)},
                          {"error", number(p.error())}};
  }
  return {{"time_s", result->time},
          {"used_time_s", result->used_time},
          {"converged", result->converged},
          {"residual_gamma1", result->residual_gamma1},
          {"residual_gamma2", result->residual_gamma2},
          {"angle_covered_rad", result->angle_covered},
          {"used_blocks", result->used_blocks},
          {"rejected_blocks", result->rejected_blocks},
          {"lost_blocks", result->lost_blocks},
          {"parameters", parameters}};
}

Json jsonOf(const cvg::DriftResult& drift) {
  if (!drift.harmonics) return {{"missing", drift.missing}};
  const cvg::RateHarmonics& fit = *drift.harmonics;
  return {{"begin_s", fit.begin_time},
          {"end_s", fit.end_time},
          {"whole_turns", fit.whole_turns},
          {"virtual_rate_rad_s", drift.virtual_rate},
          {"mean_pattern_rate_rad_s", fit.mean_rate},
          {"cosine_rad_s", fit.cosine},
          {"sine_rad_s", fit.sine},
          {"peak_to_peak_rad_s", fit.peak_to_peak},
          {"residual_rms_rad_s", fit.residual_rms}};
}

}  // namespace

std::string summaryText(const cvg::RunRecord& record, const cvg::RunSummary& summary) {
  std::string text;
  text += cvg::formatted(
      "run: %.3f s, %zu blocks, %zu missing, %zu unlocked after the first lock\n", summary.duration,
      record.blocks().size(), summary.missing_blocks, summary.unlocked_blocks);
  if (record.cut()) {
    text += "the run was cut: its end_of_run is not in the bag, or its last blocks are not\n";
  }
  if (summary.ring_up_time) {
    text += cvg::formatted("ring-up: all loops locked after %.3f s\n", *summary.ring_up_time);
  } else {
    text += "ring-up: the loops never locked\n";
  }
  if (const auto& errors = summary.loop_errors) {
    text += cvg::formatted(
        "loops: largest errors of the true motion from %.3f s to the end: "
        "phase %.4f deg, |b|/a %.2e, a %.2e relative\n",
        errors->from_time, cvg::toDegrees(errors->phase), errors->quadrature, errors->amplitude);
  }
  text += "\n";
  if (const auto& consistency = summary.consistency) {
    text += cvg::formatted(
        "filter: normalised innovation squared %.3f in the mean of %zu updates (2 +- %.3f "
        "expected), %.1f %% below %.2f\n",
        consistency->mean, consistency->updates, consistency->meanTolerance(),
        100.0 * consistency->share_inside, cvg::FilterConsistency::kBound);
  }
  const bool fits = summary.misfit.empty();
  if (!fits) {
    text += "filter: " + summary.misfit + "\n";
  } else if (summary.converged_time) {
    text += cvg::formatted("filter: converged from %.1f s on\n", *summary.converged_time);
  }
  if (!summary.before_compensation || !summary.final_estimate ||
      summary.before_compensation->time != summary.final_estimate->time) {
    printIdentification(text, "last estimate before compensation", fits,
                        summary.before_compensation);
    text += "\n";
  }
  printIdentification(text, "last estimate", fits, summary.final_estimate);
  text += "\n";
  printDrift(text, record, summary);
  return text;
}

std::string summaryJson(const cvg::RunRecord& record, const cvg::RunSummary& summary) {
  Json root = {{"duration_s", summary.duration},
               {"blocks", record.blocks().size()},
               {"missing_blocks", summary.missing_blocks},
               {"unlocked_blocks", summary.unlocked_blocks},
               {"cut", record.cut()},
               {"ring_up_s", summary.ring_up_time ? Json(*summary.ring_up_time) : Json(nullptr)}};
  root["loop_errors"] = nullptr;
  if (const auto& errors = summary.loop_errors) {
    root["loop_errors"] = {{"from_s", errors->from_time},
                           {"phase_rad", errors->phase},
                           {"b_over_a", errors->quadrature},
                           {"a_relative", errors->amplitude}};
  }
  root["settings"] = {{"session", record.session()},
                      {"block_duration_s", record.blockDuration()},
                      {"group_delay_s", record.groupDelay()},
                      {"case_rotated", record.rotated()},
                      {"true_natural_frequency_hz",
                       record.device() ? Json(record.device()->natural_frequency) : Json(nullptr)},
                      {"true_quality_factor",
                       record.device() ? Json(record.device()->quality_factor) : Json(nullptr)}};
  root["converged_s"] = summary.converged_time ? Json(*summary.converged_time) : Json(nullptr);
  if (!summary.misfit.empty()) root["misfit"] = summary.misfit;
  root["consistency"] = nullptr;
  if (const auto& consistency = summary.consistency) {
    root["consistency"] = {{"updates", consistency->updates},
                           {"mean", number(consistency->mean)},
                           {"mean_tolerance", consistency->meanTolerance()},
                           {"bound", cvg::FilterConsistency::kBound},
                           {"share_inside", consistency->share_inside}};
  }
  root["before_compensation"] = jsonOf(summary.before_compensation);
  root["final_estimate"] = jsonOf(summary.final_estimate);
  root["drift_before"] = jsonOf(summary.before);
  root["drift_after"] = jsonOf(summary.after);
  return root.dump(2) + "\n";
}

}  // namespace ring_gyro::tools
