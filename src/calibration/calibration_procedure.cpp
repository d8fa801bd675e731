#include "ring_gyro/calibration/calibration_procedure.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "ring_gyro/calibration/rate_parity.h"
#include "ring_gyro/common/angle.h"
#include "ring_gyro/common/formatted.h"
#include "ring_gyro/signals/calibration_command.h"

namespace cvg {
namespace {

constexpr double kLeastSettling = 2.0;     // [s]
constexpr double kTurnsOfALeg = 2.2;       // two whole turns, to compare one turn with another
constexpr double kLeastTurns = 2.1;        // at least, where k or drift differ from the plan
constexpr double kLeastFollowing = 0.01;   // of the expected rate of the pattern
constexpr double kSignificance = 3.0;      // of the amplitude of an order, in sigmas
constexpr double kLongestUnusable = 20.0;  // without a usable block [s]
constexpr double kApproachRate = 0.1;      // of steering to the worst angle [rad/s]

double duration(const ConverterParameters& converter, double time) {
  const double block = converter.blockDuration();
  return std::ceil(time / block) * block;
}

std::string degreesPerSecond(double rate) { return formatted("%+.4g deg/s", toDegrees(rate)); }

RateHarmonics fit(const std::vector<AngleSample>& samples, double period) {
  return fitRateHarmonics(samples, windowOfTurns(samples, period));
}

/// Sigma of a coefficient, from the difference of the halves of a leg [rad/s].
double coefficientSigma(const std::vector<AngleSample>& samples, double period) {
  const auto middle = samples.begin() + static_cast<std::ptrdiff_t>(samples.size() / 2);
  const RateHarmonics first = fit({samples.begin(), middle}, period);
  const RateHarmonics second = fit({middle, samples.end()}, period);
  double squares = 0.0;
  for (int i = 0; i < RateHarmonics::kCount; ++i) {
    squares += std::pow(first.cosine[i] - second.cosine[i], 2) +
               std::pow(first.sine[i] - second.sine[i], 2);
  }
  return 0.5 * std::sqrt(squares / (2 * RateHarmonics::kCount));
}

/// (theta + pi, phi + pi) is the same motion, so odd orders are only noise.
void keepEvenOrders(AngleHarmonics& function, std::int64_t highest) {
  function.cosine.resize(static_cast<std::size_t>(highest), 0.0);
  function.sine.resize(static_cast<std::size_t>(highest), 0.0);
  for (std::size_t i = 0; i < function.cosine.size(); i += 2) {
    function.cosine[i] = function.sine[i] = 0.0;
  }
}

/// Everything that is corrected must be estimated. Steering alone shows no rotation of the case.
ExtendedParameters withCalibratedGroups(ExtendedParameters parameters) {
  parameters.quality = parameters.frequency = true;
  parameters.drive_matrix = parameters.drift_bias = parameters.pickoff_cubic = true;
  parameters.drive_rotation = true;
  parameters.sense_matrix = parameters.estimate_rotation = false;
  return parameters;
}

/// `sigma`: of a coefficient.
void keepSignificantOrders(AngleHarmonics& function, double sigma) {
  for (std::size_t i = 0; i < function.cosine.size(); ++i) {
    if (std::hypot(function.cosine[i], function.sine[i]) < kSignificance * sigma) {
      function.cosine[i] = function.sine[i] = 0.0;
    }
  }
}

}  // namespace

CalibrationProcedure::CalibrationProcedure(const DeviceKnowledge& device,
                                           const CalibrationRunParameters& parameters,
                                           const ExtendedParameters& identification,
                                           const ConverterParameters& converter,
                                           std::int64_t period_blocks, const Corrections& initial)
    : device_(checked(device, "device")),
      parameters_(checked(parameters, "calibration_run")),
      identification_(withCalibratedGroups(identification)),
      converter_(converter),
      period_blocks_(static_cast<std::uint64_t>(period_blocks)),
      corrections_(initial) {
  if (period_blocks <= 0) {
    throw std::invalid_argument("calibration: the period must be at least one block");
  }
  result_.device.angular_gain = device.angular_gain;
  const double rate =
      parameters.survey_rate > 0.0 ? parameters.survey_rate : 0.3 * device.decayRate();
  plan(rate);
  result_.missing = missingStages();
  Leg survey;
  survey.stage = Stage::kSurvey;
  survey.result = "survey";
  survey.name = "survey at " + degreesPerSecond(rate);
  survey.virtual_rate = rate;
  survey.settling = legs_.front().settling;
  survey.duration = std::max(1.5 * kTwoPi / rate, 10.0 / device.decayRate());
  legs_.push_front(survey);
}

void CalibrationProcedure::plan(double rate) {
  legs_.clear();
  result_.steering_rate = rate;
  for (std::int64_t round = 1; round <= parameters_.identification_rounds; ++round) {
    planPair(Stage::kIdentification, "identification " + std::to_string(round), rate, 0.0,
             parameters_.identification_time);
  }
  for (std::int64_t round = 1; round <= parameters_.drift_rounds; ++round) {
    planPair(
        Stage::kDrift, "drift " + std::to_string(round), parameters_.drift_rate, 0.0,
        round < parameters_.drift_rounds ? parameters_.drift_time : parameters_.last_drift_time);
  }
  if (parameters_.rate_table) {
    planPair(Stage::kTable, "angle map", 0.0, parameters_.table_rate, parameters_.table_time);
  }
  for (const double verified : parameters_.verification_rates) {
    planPair(Stage::kVerification, "verification", parameters_.rate_table ? 0.0 : verified,
             parameters_.rate_table ? verified : 0.0, parameters_.verification_time);
  }
  if (parameters_.rate_table && !parameters_.verification_rates.empty()) {
    Leg approach;
    approach.stage = Stage::kToWorstAngle;
    approach.result = "rate threshold";
    approach.name = "steering to the worst angle";
    approach.virtual_rate = kApproachRate;
    approach.duration = 1.1 * kTwoPi / kApproachRate;
    legs_.push_back(approach);
    Leg threshold;
    threshold.stage = Stage::kThreshold;
    threshold.result = approach.result;
    threshold.name = "twice the rate threshold";
    threshold.settling = kLeastSettling;
    threshold.duration = parameters_.threshold_time;
    legs_.push_back(threshold);
  }
}

void CalibrationProcedure::planPair(Stage stage, const std::string& name, double virtual_rate,
                                    double table_rate, double asked) {
  const double rate = std::max(std::abs(virtual_rate), std::abs(table_rate));
  for (const double sign : {1.0, -1.0}) {
    Leg leg;
    leg.stage = stage;
    leg.result = name;
    leg.name = name + " at " + degreesPerSecond(sign * rate);
    leg.virtual_rate = sign * virtual_rate;
    leg.table_rate = sign * table_rate;
    leg.settling = std::max(kLeastSettling, parameters_.settling_decays / device_.decayRate());
    const double turns_time = kTurnsOfALeg * kTwoPi / patternRate(leg);
    leg.duration = duration(converter_, std::max({asked, turns_time, 10.0 / device_.decayRate()}));
    if (stage != Stage::kIdentification) leg.least_turn = kLeastTurns * kTwoPi;
    leg.second_of_pair = sign < 0.0;
    legs_.push_back(leg);
  }
}

/// Expected rate of the pattern in this leg, with the best known k [rad/s].
double CalibrationProcedure::patternRate(const Leg& leg) const {
  return std::max(std::abs(leg.virtual_rate),
                  result_.device.angular_gain * std::abs(leg.table_rate));
}

/// After k has been measured: the remaining legs were planned with the nominal k. A leg that has
/// enough turns is not changed.
void CalibrationProcedure::sizeLegs() {
  for (auto leg = legs_.begin() + 1; leg != legs_.end(); ++leg) {
    if (patternRate(*leg) * leg->duration >= leg->least_turn) continue;
    leg->duration = duration(converter_, kTurnsOfALeg * kTwoPi / patternRate(*leg));
  }
}

std::optional<CalibrationCommand> CalibrationProcedure::process(const OrbitalElements& elements,
                                                                const ControlGains& gains) {
  const BlockStamp& stamp = elements.stamp;
  const bool running = !finished_ && failure_.empty();
  if (running && stamp.sequence >= leg_begin_) record(elements, gains);
  if ((stamp.sequence + 1) % period_blocks_ != 0) return std::nullopt;

  const std::uint64_t effective = stamp.sequence + 1 + period_blocks_;
  bool found = false;
  if (running && failure_.empty() && stamp.sequence >= leg_begin_) {
    bool over = false;
    try {
      over = legOver();
      if (over) finishLeg();
    } catch (const std::exception& error) {
      failure_ = legs_.front().name + ": " + error.what();
    }
    if (over && failure_.empty()) {
      const Stage stage = legs_.front().stage;
      found = legs_.front().second_of_pair || stage == Stage::kThreshold;
      legs_.pop_front();
      result_.missing = missingStages();
      if (found) result_.corrections = correctionsForDevice();
      finished_ = legs_.empty();
      leg_begin_ = effective;
      settled_time_ = unusable_time_ = 0.0;
      passed_worst_angle_ = false;
      theta_.clear();
      output_.clear();
    }
  }
  CalibrationCommand command;
  command.session = stamp.session;
  command.effective_sequence = effective;
  command.settings = settings();
  command.leg = finished_ ? "finished" : legs_.front().name;
  command.time_left = timeLeft();
  command.found = found;
  command.finished = finished_;
  command.failure = failure_;
  return command;
}

void CalibrationProcedure::record(const OrbitalElements& elements, const ControlGains& gains) {
  const Leg& leg = legs_.front();
  const double block = elements.stamp.duration();
  result_.duration += block;
  const bool usable = elements.status.usable() && gains.status.usable();
  unusable_time_ = usable ? 0.0 : unusable_time_ + block;
  if (unusable_time_ > kLongestUnusable) {
    failure_ = leg.name + ": the loops have not been locked and unsaturated for " +
               std::to_string(kLongestUnusable) +
               " s; see the status of orbital_elements, lower the rates or raise drive_limit";
    return;
  }
  if (usable) settled_time_ += block;
  if (settled_time_ <= leg.settling) return;

  const double time = elements.stamp.end() - elements.group_delay;
  if (leg.stage == Stage::kIdentification) {
    if (!identifier_) identifier_.emplace(device_, identification_, converter_);
    if (std::optional<ExtendedEstimate> estimate = identifier_->process(elements, gains, 0.0)) {
      estimate_ = std::move(estimate);
    }
  }
  if (!usable) return;
  if (leg.stage == Stage::kToWorstAngle && !theta_.empty() && result_.threshold) {
    const double before = wrapToPi(theta_.back().theta - result_.threshold->worst_angle);
    const double now = wrapToPi(elements.orbit.theta - result_.threshold->worst_angle);
    passed_worst_angle_ |= before * now <= 0.0 && std::abs(before - now) < 1.0;
  }
  theta_.push_back({time, elements.orbit.theta});
  output_.push_back({time, elements.angle});
}

/// Angle by which the pattern has turned since the settling [rad].
double CalibrationProcedure::turned() const {
  return theta_.empty() ? 0.0 : std::abs(theta_.back().theta - theta_.front().theta);
}

bool CalibrationProcedure::legOver() const {
  if (passed_worst_angle_) return true;
  const Leg& leg = legs_.front();
  const double time = settled_time_ - leg.settling;
  if (time < leg.duration) return false;
  if (turned() >= leg.least_turn) return true;
  const double asked = std::max(std::abs(leg.virtual_rate), std::abs(leg.table_rate));
  if (turned() < kLeastFollowing * asked * time) {
    throw std::runtime_error(
        "the pattern turned by " + std::to_string(toDegrees(turned())) + " deg in " +
        std::to_string(time) + " s, less than a hundredth of that; " +
        (leg.table_rate != 0.0 ? "is the gyroscope on the table, and does the table turn?"
                               : "raise the rate above the drift"));
  }
  return false;
}

void CalibrationProcedure::finishLeg() {
  const Leg& leg = legs_.front();
  if (leg.stage == Stage::kSurvey) return finishSurvey();
  if (leg.stage == Stage::kThreshold) return finishThreshold();
  if (leg.stage == Stage::kIdentification) {
    if (leg.second_of_pair) finishIdentification();
    return;
  }
  if (leg.stage == Stage::kToWorstAngle) {
    if (!passed_worst_angle_) throw std::runtime_error("the pattern does not follow the steering");
    return;
  }
  const double period = converter_.blockDuration();
  const bool judged = leg.stage == Stage::kVerification;
  const RateHarmonics now = fit(judged ? output_ : theta_, period);
  if (!leg.second_of_pair) {
    forward_ = now;
    return;
  }
  if (leg.stage == Stage::kDrift) finishDriftRound(*forward_, now);
  if (leg.stage == Stage::kTable) finishTable(*forward_, now);
  if (leg.stage == Stage::kVerification) finishVerification(*forward_, now);
}

void CalibrationProcedure::finishSurvey() {
  const double travel = std::abs(theta_.back().theta - theta_.front().theta);
  if (travel < kTwoPi) {
    throw std::runtime_error("the pattern turned by " + std::to_string(toDegrees(travel)) +
                             " deg only; raise calibration_run/survey_rate above the drift");
  }
  // Half the swing of the rate is the effect of gamma, drive and pick-off together; only the
  // identification separates them.
  const double drift = 0.5 * fit(theta_, converter_.blockDuration()).peak_to_peak;
  const double rate = std::max(parameters_.least_rate, parameters_.rate_margin * drift);
  const Leg survey = legs_.front();
  plan(rate);
  legs_.push_front(survey);  // removed when the present leg ends
}

double CalibrationProcedure::identified(const std::string& name) const {
  return estimate_->value[*identifier_->find(name)];
}

void CalibrationProcedure::finishIdentification() {
  if (!estimate_ || !estimate_->settled) {
    throw std::runtime_error(
        "the identification has not settled; raise calibration_run/identification_time");
  }
  const auto value = [this](const char* name) { return identified(name); };
  result_.device.natural_frequency = value("natural_frequency");
  result_.device.quality_factor = kPi * result_.device.natural_frequency / value("decay_rate");
  result_.device.drive_gain = value("drive_gain");
  result_.parameters.clear();
  const std::vector<std::string>& names = identifier_->names();
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto index = static_cast<Eigen::Index>(i);
    result_.parameters.push_back({names[i], estimate_->value[index], estimate_->sigma(index)});
  }

  DrivePath residual;
  residual.phase = value("drive_phase");
  residual.mismatch = value("drive_mismatch");
  residual.skew = value("drive_skew");
  residual.rotation = value("drive_rotation");
  residual.rotation_phase = value("drive_rotation_phase");
  residual.phase_mismatch = value("phase_mismatch");
  residual.phase_skew = value("phase_skew");
  // The identified path is only the error that the acting correction leaves.
  corrections_.drive_path =
      DrivePath::of(residual.matrix() * corrections_.driveCorrection().inverse());
  corrections_.pickoff_cubic += value("pickoff_cubic");
  const double told = device_.decayRate() / device_.drive_gain;
  const double found = result_.device.decayRate() / result_.device.drive_gain;
  corrections_.gamma1 = value("gamma1") * found / told;
  corrections_.gamma2 = value("gamma2") * found / told;
  identifier_.reset();
  estimate_.reset();
}

void CalibrationProcedure::finishDriftRound(const RateHarmonics& forward,
                                            const RateHarmonics& backward) {
  DriftRound round;
  round.measured = evenPart(forward, backward);
  keepEvenOrders(round.measured, parameters_.highest_order);
  round.peak_to_peak = peakToPeak(round.measured);
  round.sigma = coefficientSigma(theta_, converter_.blockDuration()) / std::sqrt(2.0);
  corrections_.drift += round.measured;
  round.total = corrections_.drift;
  result_.drift_rounds.push_back(std::move(round));
  const auto rounds = static_cast<std::int64_t>(result_.drift_rounds.size());
  if (rounds > 1 && rounds == parameters_.drift_rounds) poolDriftRounds();
}

/// The first round is not used, because its drift may be too large to be cancelled at once. The
/// other rounds measured the same total: takes their mean without the orders that noise alone could
/// explain.
void CalibrationProcedure::poolDriftRounds() {
  AngleHarmonics sum;
  double weights = 0.0;
  for (auto round = result_.drift_rounds.begin() + 1; round != result_.drift_rounds.end();
       ++round) {
    const double weight = 1.0 / (round->sigma * round->sigma);
    sum += scaled(round->total, weight);
    weights += weight;
  }
  corrections_.drift = scaled(sum, 1.0 / weights);
  keepSignificantOrders(corrections_.drift, std::sqrt(1.0 / weights));
}

void CalibrationProcedure::finishTable(const RateHarmonics& forward,
                                       const RateHarmonics& backward) {
  AngleHarmonics odd = oddPart(forward, backward);
  keepEvenOrders(odd, parameters_.highest_order);
  keepSignificantOrders(odd, coefficientSigma(theta_, converter_.blockDuration()) / std::sqrt(2.0));
  corrections_.angle_map = angleMapOf(odd, static_cast<int>(parameters_.highest_order));
  result_.angle_map_measured = true;
  result_.device.angular_gain = angularGainOf(odd, parameters_.table_rate);
  result_.table_drift = evenPart(forward, backward);
  sizeLegs();
}

void CalibrationProcedure::finishVerification(const RateHarmonics& forward,
                                              const RateHarmonics& backward) {
  const Leg& leg = legs_.front();
  Verification verification;
  verification.rate = std::abs(parameters_.rate_table ? leg.table_rate : leg.virtual_rate);
  const double output_gain = parameters_.rate_table ? result_.device.angular_gain : 1.0;
  verification.forward_peak = forward.peak_to_peak / output_gain;
  verification.backward_peak = backward.peak_to_peak / output_gain;
  verification.forward_scale = -forward.mean_rate / (output_gain * verification.rate) - 1.0;
  verification.backward_scale = backward.mean_rate / (output_gain * verification.rate) - 1.0;
  verification.drift = scaled(evenPart(forward, backward), 1.0 / output_gain);
  verification.drift_peak_to_peak = peakToPeak(verification.drift);
  result_.verifications.push_back(std::move(verification));
  const auto next = legs_.begin() + 1;
  if (next != legs_.end() && next->stage == Stage::kToWorstAngle) aimAtWorstAngle();
}

/// Uses the mean of all verifications, which has the smallest noise.
void CalibrationProcedure::aimAtWorstAngle() {
  AngleHarmonics drift;
  for (const Verification& verification : result_.verifications) drift += verification.drift;
  drift = scaled(drift, 1.0 / static_cast<double>(result_.verifications.size()));
  const Extreme worst = largestMagnitude(drift);
  ThresholdTest test;
  test.threshold = std::abs(worst.value);
  test.worst_angle = worst.theta;
  // theta' = k (drift - rate) with the drift as a rate of the case: turn against it.
  test.rate = 2.0 * worst.value;
  result_.threshold = test;
  legs_.back().table_rate = test.rate;
}

void CalibrationProcedure::finishThreshold() {
  ThresholdTest& test = *result_.threshold;
  // The mean over half a second at each end reduces the noise of single samples.
  const auto part = static_cast<std::size_t>(0.5 / converter_.blockDuration());
  if (output_.size() < 4 * part) throw std::runtime_error("threshold_time is too short");
  const auto meanOf = [](auto begin, auto end) {
    AngleSample mean;
    for (auto it = begin; it != end; ++it) {
      mean.time += it->time;
      mean.theta += it->theta;
    }
    const double count = static_cast<double>(end - begin);
    return AngleSample{mean.time / count, mean.theta / count};
  };
  const auto length = static_cast<std::ptrdiff_t>(part);
  const AngleSample begin = meanOf(output_.begin(), output_.begin() + length);
  const AngleSample end = meanOf(output_.end() - length, output_.end());
  test.turned = end.theta - begin.theta;
  test.expected = -result_.device.angular_gain * test.rate * (end.time - begin.time);
}

/// With the gains of the identified device instead of the nominal ones in the loops.
Corrections CalibrationProcedure::correctionsForDevice() const {
  Corrections corrections = corrections_;
  const double told = device_.decayRate() / device_.drive_gain;
  const double found = result_.device.decayRate() / result_.device.drive_gain;
  corrections.gamma1 *= told / found;
  corrections.gamma2 *= told / found;
  corrections.drift = scaled(corrections.drift, result_.device.drive_gain / device_.drive_gain);
  return corrections;
}

LoopSettings CalibrationProcedure::settings() const {
  LoopSettings settings;
  settings.corrections = corrections_;
  settings.end_of_run = finished_ || !failure_.empty();
  if (settings.end_of_run) return settings;
  const Leg& leg = legs_.front();
  settings.virtual_rate = leg.virtual_rate;
  settings.table_rate = leg.table_rate;
  if (leg.stage == Stage::kIdentification) {
    settings.amplitude_modulation = parameters_.amplitude_modulation;
    settings.amplitude_modulation_frequency = parameters_.amplitude_modulation_frequency;
  }
  return settings;
}

double CalibrationProcedure::timeLeft() const {
  double time = 0.0;
  for (const Leg& leg : legs_) time += leg.settling + leg.duration;
  if (legs_.empty()) return 0.0;
  const Leg& now = legs_.front();
  const double planned = now.settling + now.duration;
  if (settled_time_ <= planned) return time - settled_time_;
  // The leg continues until the pattern has turned enough.
  const double rate = turned() / (settled_time_ - now.settling);
  const double longer = rate > 0.0 ? (now.least_turn - turned()) / rate : 0.0;
  return std::max(0.0, longer) + time - planned;
}

/// Each stage once, in order.
std::vector<std::string> CalibrationProcedure::missingStages() const {
  std::vector<std::string> stages;
  for (const Leg& leg : legs_) {
    if (stages.empty() || stages.back() != leg.result) stages.push_back(leg.result);
  }
  return stages;
}

}  // namespace cvg
