#include "ring_gyro/ros/identification_report.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>
#include <variant>

#include "ring_gyro/common/angle.h"
#include "ring_gyro/common/formatted.h"
#include "ring_gyro/configuration/parameter_text.h"

namespace ring_gyro::bridge {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kConstantAngle = 0.01;       // a pattern that covers less is at rest [rad]
constexpr double kFrequencyTolerance = 5e-3;  // of the NCO against the configured f0, relative

struct State {
  const char* name;
  const char* unit;
};
constexpr State kStates[] = {{"a", "V"},   {"b", "V"},   {"gamma1", "1"}, {"gamma2", "1"},
                             {"mu1", "1"}, {"mu2", "1"}, {"ks", "1/s^2"}};

std::string number(std::uint64_t value) { return std::to_string(value); }

/// The reasons that occurred: "12 not finite, 3 not locked".
std::string unusableText(const cvg::BlockUseCounts& uses) {
  std::string text;
  for (const UnusableReason& reason : reasonsOf(uses)) {
    if (reason.blocks == 0) continue;
    text += (text.empty() ? "" : ", ") + number(reason.blocks) + " " + reason.text;
  }
  return text;
}

/// Messages that lost their partner, except where recording began and ended.
std::uint64_t aloneWithin(const IdentificationReport& report) {
  return report.pairs.elements_alone + report.pairs.gains_alone - report.alone_at_start -
         report.alone_at_end;
}

std::string noPairs(const IdentificationReport& report) {
  if (report.elements.zero_stamps + report.gains.zero_stamps > 0) {
    return "every stamp is zero: have the source set header.stamp to the end of the block";
  }
  if (report.elements.accepted == 0 || report.gains.accepted == 0) {
    return "no message in the chosen span: give another --start or --duration";
  }
  return "no orbital elements and control gains of the same block (session, sequence and stamp): "
         "record both topics of one run";
}

std::string noneUsable(const IdentificationReport& report,
                       const cvg::LoopConfiguration& configuration) {
  const auto any = [&report](cvg::BlockUse use) { return report.uses.of(use) > 0; };
  std::string line = "none of " + number(report.uses.unusable()) +
                     " blocks can be used: " + unusableText(report.uses) + "; ";
  if (any(cvg::BlockUse::kWrongDuration)) {
    line += cvg::formatted(
        "blocks last %g s, the configuration says %g s: set converter/sample_rate and "
        "converter/block_samples",
        1e-9 * static_cast<double>(report.wrong_duration_ns),
        configuration.converter.blockDuration());
  } else if (!report.first_refused.empty()) {
    line += "check what recorded a, b, theta, phi and the drive, first " + report.first_refused;
  } else if (any(cvg::BlockUse::kNotFinite) || any(cvg::BlockUse::kNoAmplitude)) {
    line += "check what recorded a, b, theta, phi and the drive";
  } else if (any(cvg::BlockUse::kNoFrequency)) {
    line += "check what recorded the reference frequency";
  } else if (any(cvg::BlockUse::kGroupDelay)) {
    line += "check the group delay, in seconds";
  } else {
    line += "record on until all loops have locked";
  }
  return line;
}

Json jsonNumber(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json jsonOf(const cvg::Parameter& parameter) {
  return std::visit([](const auto& target) { return Json(*target); }, parameter.target);
}

/// The settings that affect the filter; the rest of a configuration does not.
Json settingsJson(const cvg::LoopConfiguration& configuration) {
  static const std::set<std::string> kUsed = {"converter", "device", "identification"};
  cvg::LoopConfiguration copy = configuration;
  Json settings = Json::object();
  for (const cvg::Section& section : copy.sections()) {
    if (kUsed.count(section.name) == 0) continue;
    Json& values = settings[section.name] = Json::object();
    for (const cvg::Parameter& parameter : section.table.parameters()) {
      values[parameter.key] = jsonOf(parameter);
    }
  }
  return settings;
}

Json countsJson(const IdentificationReport& report) {
  const auto& estimate = report.estimate;
  Json counts = {{"used", estimate ? estimate->used_blocks : 0},
                 {"dropped", estimate ? estimate->rejected_blocks : 0},
                 {"gaps", estimate ? estimate->lost_blocks : 0},
                 {"pairs", report.pairs.pairs},
                 {"before_start_sequence", report.before_start},
                 {"elements_without_gains", report.pairs.elements_alone},
                 {"gains_without_elements", report.pairs.gains_alone},
                 {"alone_at_the_ends", report.alone_at_start + report.alone_at_end},
                 {"out_of_order", report.elements.steps_back + report.gains.steps_back},
                 {"duplicates", report.elements.duplicates + report.gains.duplicates},
                 {"zero_stamps", report.elements.zero_stamps + report.gains.zero_stamps},
                 {"new_sessions", report.elements.new_sessions},
                 {"filter_restarts", report.filter_restarts},
                 {"not_delivered", report.not_delivered}};
  // Rare counts are written only if they are not zero.
  const auto addIfAny = [](Json& to, const char* key, std::uint64_t count) {
    if (count > 0) to[key] = count;
  };
  addIfAny(counts, "partner_overdue", report.pairs.overdue);
  addIfAny(counts, "left_sessions", report.elements.left_sessions + report.gains.left_sessions);
  Json& unusable = counts["unusable"] = Json::object();
  for (const UnusableReason& reason : reasonsOf(report.uses)) {
    if (reason.always || reason.blocks > 0) unusable[reason.key] = reason.blocks;
  }
  return counts;
}

Json covarianceJson(const cvg::StateMatrix& covariance) {
  Json rows = Json::array();
  for (int i = 0; i < 7; ++i) {
    Json row = Json::array();
    for (int j = 0; j < 7; ++j) row.push_back(jsonNumber(covariance(i, j)));
    rows.push_back(std::move(row));
  }
  return rows;
}

Json consistencyJson(std::uint64_t updates, double sum) {
  if (updates == 0) return nullptr;
  const cvg::NisBounds bounds = cvg::nisBounds(updates);
  const double mean = sum / static_cast<double>(updates);
  return {{"updates", updates},
          {"mean_nis", jsonNumber(mean)},
          {"lower_95", bounds.lower},
          {"upper_95", bounds.upper},
          {"consistent", mean >= bounds.lower && mean <= bounds.upper}};
}

std::string consistencyText(const char* name, std::uint64_t updates, double sum) {
  if (updates == 0) return "";
  const cvg::NisBounds bounds = cvg::nisBounds(updates);
  const double mean = sum / static_cast<double>(updates);
  return cvg::formatted("  %-12s mean NIS %.3f of %llu updates, 95 %% bounds [%.3f, %.3f]: %s\n",
                        name, mean, static_cast<unsigned long long>(updates), bounds.lower,
                        bounds.upper,
                        mean < bounds.lower   ? "less noise than assumed"
                        : mean > bounds.upper ? "more noise than assumed, or not this model"
                                              : "consistent");
}

Json resultJson(const IdentificationResult& result, const cvg::LoopConfiguration& configuration,
                const Json& settings) {
  const IdentificationReport& report = result.report;
  const std::string failure = failureOf(report, configuration);
  Json json;
  json["bags"] = result.sources;
  json["identified"] = failure.empty();
  json["failure"] = failure.empty() ? Json(nullptr) : Json(failure);
  json["damage"] = result.damage;
  json["faults"] = faultsOf(report, configuration);
  json["converged"] = report.estimate && report.estimate->converged && report.nis.misfit().empty();
  json["convergence_time_s"] =
      report.convergence_time ? Json(*report.convergence_time) : Json(nullptr);
  json["data"] = {{"session", report.last.session},
                  {"first_sequence", report.first.sequence},
                  {"last_sequence", report.last.sequence},
                  {"first_stamp_ns", report.first.end_ns},
                  {"last_stamp_ns", report.last.end_ns}};
  if (const auto& estimate = report.estimate) {
    Json& parameters = json["parameters"] = Json::object();
    const cvg::StateMatrix covariance = estimate->covariance.matrix();
    for (int i = 0; i < 7; ++i) {
      parameters[kStates[i].name] = {{"value", jsonNumber(estimate->value[i])},
                                     {"sigma", jsonNumber(std::sqrt(covariance(i, i)))},
                                     {"unit", kStates[i].unit}};
    }
    json["residual_gamma"] = {jsonNumber(estimate->residual_gamma1),
                              jsonNumber(estimate->residual_gamma2)};
    json["covariance"] = covarianceJson(covariance);
    json["angle_covered_rad"] = jsonNumber(estimate->angle_covered);
    json["estimate_sequence"] = estimate->stamp.sequence;
  } else {
    json["parameters"] = nullptr;
  }
  json["consistency"] = {
      {"all", consistencyJson(report.nis.updates, report.nis.sum)},
      {"since_converged", consistencyJson(report.nis.updates_converged, report.nis.sum_converged)}};
  json["counts"] = countsJson(report);
  json["settings"] = settings;
  return json;
}

void addParameters(std::string& text, const cvg::ParameterEstimate& estimate) {
  for (int i = cvg::kGamma1; i <= cvg::kDriveGain; ++i) {
    text += cvg::formatted("  %-12s % 15.8e +- %.1e  %s\n", kStates[i].name, estimate.value[i],
                           estimate.sigma(static_cast<cvg::StateIndex>(i)), kStates[i].unit);
  }
}

}  // namespace

std::vector<UnusableReason> reasonsOf(const cvg::BlockUseCounts& uses) {
  using cvg::BlockUse;
  const auto of = [&uses](BlockUse use) { return uses.of(use); };
  return {
      {"not_finite", "not finite", of(BlockUse::kNotFinite), true},
      {"no_amplitude", "without amplitude (a not above |b|)", of(BlockUse::kNoAmplitude), true},
      {"wrong_duration", "of another duration than configured", of(BlockUse::kWrongDuration), true},
      {"invalid_samples", "with invalid samples", of(BlockUse::kInvalidSamples), true},
      {"saturated", "saturated", of(BlockUse::kSaturated), true},
      {"not_locked", "not locked", of(BlockUse::kNotLocked), true},
      {"impossible", "with impossible numbers",
       of(BlockUse::kImpossible) + of(BlockUse::kOtherBlock), false},
      {"contradiction", "whose drive contradicts its parts", of(BlockUse::kContradiction), false},
      {"no_frequency", "without a reference frequency", of(BlockUse::kNoFrequency), false},
      {"group_delay", "with too long a group delay", of(BlockUse::kGroupDelay), false},
      {"after_break", "with one of these still in the demodulator", of(BlockUse::kAfterBreak),
       false}};
}

std::string mainReasonOf(const cvg::BlockUseCounts& uses) {
  const std::vector<UnusableReason> reasons = reasonsOf(uses);
  const auto most = std::max_element(
      reasons.begin(), reasons.end(),
      [](const UnusableReason& a, const UnusableReason& b) { return a.blocks < b.blocks; });
  return most->blocks == 0 ? "" : number(most->blocks) + " " + most->text;
}

Verdict verdictOf(const IdentificationResult& result, const cvg::LoopConfiguration& configuration) {
  if (!failureOf(result.report, configuration).empty()) return Verdict::kFailed;
  const bool faulty = !result.damage.empty() || !faultsOf(result.report, configuration).empty();
  return faulty ? Verdict::kIdentifiedWithFaults : Verdict::kIdentified;
}

std::string failureOf(const IdentificationReport& report,
                      const cvg::LoopConfiguration& configuration) {
  if (report.pairs.pairs == 0) return noPairs(report);
  if (report.pairs.pairs == report.before_start) {
    return "no block from the start sequence on, the last is " + number(report.last.sequence) +
           ": give a smaller --start-sequence";
  }
  if (report.uses.usable() == 0) return noneUsable(report, configuration);
  if (report.nis.updates == 0) {
    return cvg::formatted(
        "no two whole periods of %g s with usable blocks only: record for longer, or set "
        "a shorter identification/update_period",
        configuration.identification.update_period);
  }
  if (report.estimate->angle_covered < kConstantAngle) {
    return cvg::formatted(
        "theta stands still (%.1e rad covered), so nothing tells the parameters apart: "
        "steer the pattern or turn the gyroscope while recording",
        report.estimate->angle_covered);
  }
  return "";
}

std::vector<std::string> faultsOf(const IdentificationReport& report,
                                  const cvg::LoopConfiguration& configuration) {
  std::vector<std::string> faults;
  const std::string misfit = report.nis.misfit();
  if (!misfit.empty()) faults.push_back(misfit);
  const auto add = [&faults](std::uint64_t count, const std::string& what) {
    if (count > 0) faults.push_back(number(count) + " " + what);
  };
  const cvg::TimeGuard::Counts& elements = report.elements;
  const cvg::TimeGuard::Counts& gains = report.gains;
  add(report.not_delivered,
      "messages of the bag were not delivered by its replay: play it with a larger --queue, or a "
      "lower rate");
  add(elements.lost, "blocks missing in gaps of the orbital elements");
  add(gains.lost, "blocks missing in gaps of the control gains");
  add(aloneWithin(report), "messages whose partner on the other topic is missing");
  add(std::max(elements.steps_back, gains.steps_back),
      "steps back in the stamps: the filter started afresh at each");
  add(std::max(elements.new_sessions, gains.new_sessions),
      "new sessions of the plant: the filter started afresh at each");
  add(elements.duplicates + gains.duplicates, "duplicate messages, left out");
  add(elements.zero_stamps + gains.zero_stamps, "messages with zero stamps, left out");
  add(elements.left_sessions + gains.left_sessions,
      "messages of a session that had been left, left out: two plants at once?");
  add(report.pairs.overdue,
      cvg::formatted("of those alone because the other topic was silent for %zu blocks",
                     cvg::PairMerge::kMostWaiting));
  if (!report.first_refused.empty()) faults.push_back("refused " + report.first_refused);
  add(report.uses.of(cvg::BlockUse::kNotFinite),
      "blocks with numbers that are not finite, left out");
  add(report.uses.of(cvg::BlockUse::kNoAmplitude), "blocks with a not above |b|, left out");
  add(report.uses.of(cvg::BlockUse::kWrongDuration),
      "blocks of another duration than configured, left out");
  add(report.uses.of(cvg::BlockUse::kImpossible) + report.uses.of(cvg::BlockUse::kOtherBlock),
      "blocks with impossible numbers, left out");
  add(report.uses.of(cvg::BlockUse::kContradiction),
      "blocks whose drive contradicts its parts, left out");
  add(report.uses.of(cvg::BlockUse::kNoFrequency),
      "blocks without a reference frequency, left out");
  add(report.uses.of(cvg::BlockUse::kGroupDelay), "blocks with too long a group delay, left out");
  if (report.uses.usable() > 0) {
    const double frequency =
        report.frequency_sum / static_cast<double>(report.uses.usable()) / cvg::kTwoPi;
    const double configured = configuration.device.natural_frequency;
    if (!(std::abs(frequency - configured) < kFrequencyTolerance * configured)) {
      faults.push_back(
          cvg::formatted("the reference ran at %.6g Hz, device/natural_frequency is %.6g Hz: "
                         "is it the configuration of this device?",
                         frequency, configured));
    }
  }
  return faults;
}

std::string identificationText(const IdentificationResult& result,
                               const cvg::LoopConfiguration& configuration) {
  const IdentificationReport& report = result.report;
  std::string text;
  for (const std::string& source : result.sources) text += source + "\n";
  const std::string failure = failureOf(report, configuration);
  if (!failure.empty() || !report.estimate) return text + "  not identified\n";
  const cvg::ParameterEstimate& estimate = *report.estimate;
  addParameters(text, estimate);
  if (!report.nis.misfit().empty()) {
    text += cvg::formatted("  %-12s no: the data do not fit the model, whatever the sigmas say\n",
                           "converged");
  } else {
    text += report.convergence_time
                ? cvg::formatted("  %-12s after %.1f s\n", "converged", *report.convergence_time)
                : cvg::formatted("  %-12s not within the data\n", "converged");
  }
  text += cvg::formatted(
      "  %-12s %.3f s in session %u, sequence %llu to %llu, %.2f turns of theta\n", "data",
      report.last.end() - report.first.end() + report.first.duration(), report.last.session,
      static_cast<unsigned long long>(report.first.sequence),
      static_cast<unsigned long long>(report.last.sequence), estimate.angle_covered / cvg::kTwoPi);
  text += cvg::formatted("  %-12s %llu used, %llu dropped, %llu in gaps, %llu out of order\n",
                         "blocks", static_cast<unsigned long long>(estimate.used_blocks),
                         static_cast<unsigned long long>(estimate.rejected_blocks),
                         static_cast<unsigned long long>(estimate.lost_blocks),
                         static_cast<unsigned long long>(report.elements.steps_back));
  const std::string unusable = unusableText(report.uses);
  if (!unusable.empty()) text += cvg::formatted("  %-12s %s\n", "unusable", unusable.c_str());
  text += consistencyText("filter", report.nis.updates, report.nis.sum);
  text += consistencyText("  converged", report.nis.updates_converged, report.nis.sum_converged);
  return text;
}

std::string identificationJson(const std::vector<IdentificationResult>& results,
                               const cvg::LoopConfiguration& configuration) {
  const Json settings = settingsJson(configuration);
  Json runs = Json::array();
  for (const IdentificationResult& result : results) {
    runs.push_back(resultJson(result, configuration, settings));
  }
  Json root = {{"version", RING_GYRO_VERSION}};
  root["runs"] = std::move(runs);
  return root.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace ring_gyro::bridge
