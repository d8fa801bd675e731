#include "ring_gyro/logs/log_importer.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <stdexcept>

#include "ring_gyro/common/angle.h"
#include "ring_gyro/common/formatted.h"
#include "ring_gyro/common/number_text.h"
#include "ring_gyro/demodulation/orbit.h"
#include "ring_gyro/signals/envelope.h"

namespace cvg {
namespace {

using Complex = std::complex<double>;
using Form = ColumnMap::Motion;

constexpr std::size_t kHeadRows = 2000;
constexpr double kBlock = 1e-3;                   // into which faster rows are averaged [s]
constexpr double kLowestFrequency = 100.0;        // of a resonator [Hz]
constexpr double kLongestBlock = 100.0;           // [s]
constexpr double kLargestDrive = 1e6;             // computed from possible gains [V]
constexpr double kLatestTime = 4294967295.0;      // that a stamp can hold [s]
constexpr double kLockedPhase = toRadians(30.0);  // of phi about -pi/2
constexpr double kLargestPhase = 30.0;            // that is not in degrees [rad]
constexpr double kUsualAmplitude = 0.9;           // of the median amplitude
constexpr double kLockedQuadrature = 0.1;         // of b to a
constexpr double kRateBandwidth = 5.0;            // of the smoothed precession rate [Hz]
constexpr double kLongestDelay = 31.0;            // that the identifier can use [blocks]

std::string text(double value) {
  std::string result;
  appendNumber(result, value);
  return result;
}

void checkOptions(ImportOptions options) {
  ParameterTable table;
  const auto add = [&table](const char* name, double& value, const char* unit, Range range) {
    table.number(name, value, unit, range, "");
  };
  add("group-delay", options.group_delay, "s", infoOf(Quantity::kGroupDelay).range);
  add("phi-offset", options.phi_offset, "rad", infoOf(Quantity::kPhi).range);
  add("attenuation", options.stopband_attenuation, "dB", Range::between(0.0, 300.0));
  if (options.drive_lead)
    add("drive-lead", *options.drive_lead, "s", Range::between(-100.0, 100.0));
  if (options.drive_gain)
    add("drive-gain", *options.drive_gain, "1/s^2", Range::between(1e-9, 1e18));
  if (options.minimum_amplitude) {
    add("minimum-amplitude", *options.minimum_amplitude, "V", Range::between(0.0, 1e3));
  }
  requireInRange(table, "--");
}

const ColumnMap& completed(const ColumnMap& map, const ImportOptions& options) {
  checkOptions(options);
  map.requireComplete(options.sample_rate.has_value());
  return map;
}

std::int64_t nanoseconds(double seconds) {
  return static_cast<std::int64_t>(std::round(1e9 * seconds));
}

}  // namespace

LogImporter::LogImporter(RecordSource& source, const ColumnMap& map, const ImportOptions& options)
    : map_(map),
      options_(options),
      rows_(source, completed(map, options), options.mirror),
      drive_(map, options.drive_gain) {
  readHead();
  choosePeriod();
  chooseBlocks();
  for (const HeadRow& each : head_) checkRow(each.row, each.place);
  chooseAmplitude();
  checkPhase();
  if (map_.motion() == Form::kSamples) makeDemodulator();
  checkDelay();
}

void LogImporter::fail(const std::string& place, const std::string& fault,
                       const std::string& mend) const {
  throw LogError(map_.file(), place, fault, mend);
}

void LogImporter::note(const RowError& error) {
  if (!options_.partial) throw error;
  counts_.faults.add(error);
}

bool LogImporter::nextGood(LogRow& row, const std::function<void(const RowError&)>& note_fault) {
  for (;;) {
    try {
      return rows_.next(row);
    } catch (const RowError& error) {
      note_fault(error);
    }
  }
}

/// A table that is parsed wrongly gives absurd values, and also rows of other lengths. The lengths
/// are the better hint, so their error comes first.
void LogImporter::readHead() {
  std::optional<RowError> absurd;
  const auto note_later = [&](const RowError& error) {
    if (options_.partial || error.kind() != RowFault::kOutOfRange) return note(error);
    if (!absurd) absurd = error;
    if (rows_.count() > kHeadRows) throw RowError(*absurd);
  };
  HeadRow each;
  while (rows_.count() < kHeadRows + counts_.faults.total() && nextGood(each.row, note_later)) {
    each.place = rows_.place();
    head_.push_back(each);
  }
  if (absurd) throw RowError(*absurd);
  if (head_.size() >= 2) return;
  fail("", "has " + std::to_string(head_.size()) + " rows that can be used",
       counts_.faults.first.empty() ? "give a longer log"
                                    : "the first that cannot: " + counts_.faults.first);
}

void LogImporter::choosePeriod() {
  double period = 0.0;
  if (options_.sample_rate) {
    period = 1.0 / *options_.sample_rate;
  } else {
    std::vector<double> times;
    for (const HeadRow& each : head_) times.push_back(valueOf(each.row, Quantity::kTime));
    try {
      period = samplingPeriod(times);
    } catch (const std::invalid_argument& error) {
      fail("", error.what(), "say --column t=COLUMN, or give --sample-rate");
    }
  }
  if (!(period > 1e-9 && period < 100.0)) {
    fail("", "a row every " + text(period) + " s cannot be",
         "give the unit of time, such as --column t=COLUMN:ms");
  }
  clock_.emplace(period);
}

void LogImporter::chooseBlocks() {
  const double fitting = std::round(kBlock / clock_->period());
  if (has(Quantity::kSequence)) {
    rows_per_block_ = 1;
  } else if (options_.average > 0) {
    rows_per_block_ = options_.average;
  } else if (fitting >= 2.0) {
    rows_per_block_ = static_cast<std::int64_t>(fitting);
  }
  const double duration = clock_->period() * static_cast<double>(rows_per_block_);
  if (duration > kLongestBlock) {
    fail("", "a block of " + text(duration) + " s is too long, allowed are " + text(kLongestBlock),
         "gather fewer rows into each with --average");
  }
  duration_ns_ = nanoseconds(duration);
  if (duration_ns_ < 1) fail("", "the rows are too close", "average more with --average");
}

void LogImporter::makeDemodulator() {
  ConverterParameters converter;
  converter.sample_rate = 1.0 / clock_->period();
  converter.block_samples = rows_per_block_;
  DemodulationParameters demodulation;
  demodulation.stopband_attenuation = options_.stopband_attenuation;
  const auto running = std::find_if(head_.begin(), head_.end(), [](const HeadRow& each) {
    return valueOf(each.row, Quantity::kOmega) > 0.0;
  });
  try {
    if (running == head_.end()) throw std::invalid_argument("the reference frequency is zero");
    if (rows_per_block_ < 2) throw std::invalid_argument("one sample a block");
    demodulator_ = std::make_unique<Demodulator>(demodulation, converter,
                                                 valueOf(running->row, Quantity::kOmega) / kTwoPi);
  } catch (const std::invalid_argument& error) {
    fail("", std::string("the samples cannot be demodulated: ") + error.what(),
         "record them faster, or log demodulated elements");
  }
}

double LogImporter::groupDelay() const {
  if (demodulator_) return demodulator_->groupDelay() + options_.group_delay;
  // The mean over a block is valid in its middle.
  return options_.group_delay + 0.5 * static_cast<double>(rows_per_block_ - 1) * clock_->period();
}

std::string LogImporter::groupDelayText() const {
  const std::optional<ColumnUse>& use = map_.use(Quantity::kGroupDelay);
  if (use && use->column) return "from column " + map_.names()[*use->column];
  return formatted("%.9g s", use ? use->constant : groupDelay());
}

void LogImporter::checkDelay() const {
  const double blocks = groupDelay() / (1e-9 * static_cast<double>(duration_ns_));
  if (blocks >= 0.0 && blocks <= kLongestDelay) return;
  fail("", "a group delay of " + text(groupDelay()) + " s is " + text(blocks) + " blocks",
       "it must be 0 to 31 of them: gather more rows into each with --average");
}

/// Rows of a ring-up contain little information, and loops at their limits often do not log the
/// real drive.
void LogImporter::chooseAmplitude() {
  if (options_.minimum_amplitude || map_.motion() == Form::kSamples) {
    minimum_amplitude_ = options_.minimum_amplitude.value_or(0.0);
    return;
  }
  std::vector<double> amplitudes;
  for (const HeadRow& each : head_) amplitudes.push_back(orbitOf(each.row).a);
  const auto middle = amplitudes.begin() + static_cast<std::ptrdiff_t>(amplitudes.size() / 2);
  std::nth_element(amplitudes.begin(), middle, amplitudes.end());
  minimum_amplitude_ = kUsualAmplitude * *middle;
}

/// This package assumes phi = -pi/2 when locked; labs may lock at another phase.
void LogImporter::checkPhase() const {
  const bool elements = map_.motion() == Form::kElements;
  if (map_.motion() == Form::kSamples || (elements && !has(Quantity::kPhi))) return;
  double largest = 0.0;
  for (const HeadRow& each : head_) largest = std::max(largest, orbitOf(each.row).a);
  Complex sum = 0.0;  // of twice phi, because phi and phi + pi are the same motion
  double phi = 0.0;
  for (const HeadRow& each : head_) {
    const Orbit orbit = orbitOf(each.row);
    if (orbit.a < 0.5 * largest) continue;
    sum += std::polar(1.0, 2.0 * orbit.phi);
    phi = orbit.phi;
  }
  const double deviation = toDegrees(0.5 * std::arg(-sum));
  const bool degrees = elements && std::abs(phi) > kLargestPhase;
  if (std::abs(deviation) < toDegrees(kLockedPhase) && !degrees) return;
  const std::string offset = text(std::round(toDegrees(wrapToPi(-0.5 * kPi - phi))));
  fail("",
       "phi, such as " + text(phi) + " rad, is " + text(0.1 * std::round(10.0 * deviation)) +
           " deg away from -90 deg, where this package has it locked",
       degrees ? "if it is in degrees say --column phi=COLUMN:deg"
               : "if that is the lab's reference say --phi-offset " + offset + "deg");
}

Orbit LogImporter::orbitOf(const LogRow& row) const {
  Orbit orbit;
  if (map_.motion() == Form::kEnvelope) {
    orbit = orbitFromEnvelope({Complex(valueOf(row, Quantity::kCx), -valueOf(row, Quantity::kSx)),
                               Complex(valueOf(row, Quantity::kCy), -valueOf(row, Quantity::kSy))});
  } else {
    orbit.a = valueOf(row, Quantity::kA);
    orbit.b = valueOf(row, Quantity::kB);
    orbit.theta = valueOf(row, Quantity::kTheta);
    orbit.phi = has(Quantity::kPhi) ? valueOf(row, Quantity::kPhi) : -0.5 * kPi;
  }
  orbit.phi += options_.phi_offset;
  return orbit;
}

/// phi in (-pi, 0] and theta without jumps. Where the drive is computed from theta, theta and
/// theta + pi are equivalent, so logs with theta folded into half a turn can be used too.
Orbit LogImporter::onBranch(Orbit orbit) {
  const double half_turns = std::ceil(orbit.phi / kPi);
  if (half_turns != 0.0) {
    orbit.phi -= half_turns * kPi;
    orbit.theta -= half_turns * kPi;
  }
  if (last_theta_) {
    const double period = map_.hasDriveEnvelopes() ? kTwoPi : kPi;
    const double periods = std::round((orbit.theta - *last_theta_) / period);
    if (periods != 0.0) orbit.theta -= period * periods;
  }
  last_theta_ = orbit.theta;
  return orbit;
}

void LogImporter::checkRow(const LogRow& row, const std::string& place) const {
  const double frequency = valueOf(row, Quantity::kOmega) / kTwoPi;
  // Zero means not running yet.
  if (frequency != 0.0 && !(frequency >= kLowestFrequency)) {
    fail(place, "a reference frequency of " + text(frequency) + " Hz cannot be",
         "give its unit, such as --column omega=COLUMN:Hz");
  }
}

std::int64_t LogImporter::rowsSinceLast(const LogRow& row, const std::string& place) {
  if (has(Quantity::kSequence)) {
    const double sequence = valueOf(row, Quantity::kSequence);
    const bool whole = sequence == std::round(sequence) && sequence >= 0.0 && sequence < 9e15;
    if (!whole || (started_ && sequence <= static_cast<double>(row_index_))) {
      throw RowError(RowFault::kTime, map_.file(), place,
                     "sequence " + text(sequence) + " does not grow",
                     "leave such rows out with --partial");
    }
    return static_cast<std::int64_t>(sequence) - row_index_;
  }
  if (!has(Quantity::kTime)) return started_ ? 1 : 0;
  try {
    return clock_->step(valueOf(row, Quantity::kTime));
  } catch (const std::invalid_argument& error) {
    throw RowError(RowFault::kTime, map_.file(), place, error.what(),
                   "leave such rows out with --partial; where only the clock is at fault, give "
                   "--sample-rate and --ignore t");
  }
}

/// A stamp is the end of the time that a row covers; a sample covers the time until the next one.
void LogImporter::setOrigin(const LogRow& row, const std::string& place) {
  const double period = clock_->period();
  double end = has(Quantity::kTime) ? valueOf(row, Quantity::kTime) : period;
  if (demodulator_) end += period;
  if (!(end < kLatestTime)) {
    fail(place, "time " + text(end) + " s is out of range",
         "give the unit of time, such as --column t=COLUMN:ns");
  }
  if (!(nanoseconds(end) >= nanoseconds(period))) end = 1.0 + period;  // stamps are above zero
  const std::int64_t position = row_index_ % rows_per_block_;
  first_block_ = row_index_ / rows_per_block_;
  origin_ns_ =
      nanoseconds(end) + nanoseconds(period * static_cast<double>(rows_per_block_ - 1 - position));
}

void LogImporter::take(const LogRow& row, const std::string& place) {
  checkRow(row, place);
  const std::int64_t step = rowsSinceLast(row, place);
  const bool contiguous = started_ && step == 1;
  row_index_ += step;
  if (!started_) {
    setOrigin(row, place);
    started_ = true;
  } else {
    counts_.missing_rows += static_cast<std::uint64_t>(step - 1);
    counts_.duration += static_cast<double>(step) * clock_->period();
  }
  const std::int64_t whole_blocks = row_index_ / rows_per_block_ - first_block_;
  const double blocks = static_cast<double>(whole_blocks);
  const double end =
      1e-9 * (static_cast<double>(origin_ns_) + blocks * static_cast<double>(duration_ns_));
  if (!(end < kLatestTime)) {
    throw RowError(RowFault::kTime, map_.file(), place,
                   "lies " + text(blocks) + " blocks behind the first, later than a stamp can say",
                   "mend its time or sequence, or leave such rows out with --partial");
  }
  if (!contiguous) last_.reset();
  const bool wanted = beginOrContinueBlock(contiguous);
  try {
    if (demodulator_) {
      if (wanted) addSample(row);
    } else {
      checkTheta(row, place);
      addMotion(row);  // unused rows too, because theta must be unwrapped
    }
  } catch (const std::range_error& error) {
    breakBlock();
    last_.reset();
    throw RowError(RowFault::kOutOfRange, map_.file(), place, error.what(),
                   "if beta, alpha or omega have other units say --column beta=COLUMN:UNIT (or a "
                   "factor); --partial leaves such rows out");
  } catch (const std::invalid_argument& error) {
    fail(place, error.what(),
         "give --drive-gain (ks as the lab's loops assumed it), steering_volts or drive envelopes");
  }
}

/// Whether this row belongs to a block without missing rows so far.
bool LogImporter::beginOrContinueBlock(bool contiguous) {
  const std::int64_t position = row_index_ % rows_per_block_;
  if (!contiguous || position != next_in_block_) breakBlock();
  if (position == 0) next_in_block_ = 0;
  if (next_in_block_ == position) return true;
  ++counts_.left_over_rows;
  return false;
}

void LogImporter::breakBlock() {
  counts_.left_over_rows += static_cast<std::uint64_t>(std::max<std::int64_t>(0, next_in_block_));
  next_in_block_ = -1;
  if (!demodulator_) return;
  demodulator_->reset();
  blocks_to_settle_ = demodulator_->settlingBlocks();
  last_.reset();
}

void LogImporter::trackRate(const Orbit& orbit, double period) {
  if (!last_) return;
  const double rate = (orbit.theta - last_->orbit.theta) / period;
  const double share = rate_known_ ? 1.0 - std::exp(-kTwoPi * kRateBandwidth * period) : 1.0;
  theta_rate_ += share * (rate - theta_rate_);
  rate_known_ = true;
}

/// The drive of an interval was pointed with the motion at the start of the interval.
void LogImporter::driveOf(const LogRow& acted, const Orbit& now, double period, double group_delay,
                          ControlGains& gains) const {
  double lead = options_.drive_lead.value_or(group_delay + 0.5 * period);
  Orbit pointed = last_ ? last_->orbit : now;
  if (!last_) lead -= period;
  pointed.theta += theta_rate_ * lead;
  drive_.rebuild(acted, pointed, gains);
  const double largest = (gains.drive.sustain.cwiseAbs() + gains.drive.quadrature.cwiseAbs() +
                          gains.drive.steering.cwiseAbs() + gains.drive.compensation.cwiseAbs())
                             .maxCoeff();
  if (largest <= kLargestDrive) return;
  throw std::range_error("its gains make a drive of " + text(largest) + " V; allowed: up to " +
                         text(kLargestDrive) + " V");
}

/// A theta in radians, wrapped or not, never jumps by much more than a turn.
void LogImporter::checkTheta(const LogRow& row, const std::string& place) {
  if (map_.motion() != Form::kElements) return;
  const double theta = valueOf(row, Quantity::kTheta);
  if (last_ && std::abs(theta - valueOf(last_->row, Quantity::kTheta)) > kTwoPi + 1.0) {
    fail(place,
         "theta jumps from " + text(valueOf(last_->row, Quantity::kTheta)) + " to " + text(theta) +
             " rad",
         "if it is in degrees say --column theta=COLUMN:deg");
  }
}

void LogImporter::addMotion(const LogRow& row) {
  Moment now{onBranch(orbitOf(row)), row};
  trackRate(now.orbit, clock_->period());
  // The gains of a row acted before its time, after it, or are values at its time.
  const bool known = last_ || options_.gain_timing == ImportOptions::GainTiming::kBefore;
  if (next_in_block_ >= 0 && !known) {
    ++counts_.left_over_rows;
    breakBlock();
  }
  if (next_in_block_ >= 0) {
    Moment acted = now;
    if (options_.gain_timing == ImportOptions::GainTiming::kAfter) acted.row = last_->row;
    if (options_.gain_timing == ImportOptions::GainTiming::kAt) {
      acted.row = 0.5 * (last_->row + row);
    }
    ControlGains gains;
    const double delay =
        has(Quantity::kGroupDelay) ? valueOf(row, Quantity::kGroupDelay) : options_.group_delay;
    driveOf(acted.row, now.orbit, clock_->period(), delay, gains);
    acted.row[static_cast<Eigen::Index>(indexOf(Quantity::kUsable))] =
        valueOf(row, Quantity::kUsable);
    addToBlock(acted, gains);
    if (next_in_block_ == rows_per_block_) {
      emit();
      next_in_block_ = 0;
    }
  }
  last_ = now;
}

void LogImporter::addToBlock(const Moment& moment, const ControlGains& gains) {
  ++next_in_block_;
  if (next_in_block_ == 1) {
    block_ = moment;
    block_gains_ = gains;
    return;
  }
  block_.orbit.a += moment.orbit.a;
  block_.orbit.b += moment.orbit.b;
  block_.orbit.theta += moment.orbit.theta;
  block_.orbit.phi += moment.orbit.phi;
  block_.row += moment.row;
  block_gains_.reference_frequency += gains.reference_frequency;
  block_gains_.beta += gains.beta;
  block_gains_.alpha += gains.alpha;
  block_gains_.virtual_rate += gains.virtual_rate;
  block_gains_.compensation.gain1 += gains.compensation.gain1;
  block_gains_.compensation.gain2 += gains.compensation.gain2;
  block_gains_.drive.sustain += gains.drive.sustain;
  block_gains_.drive.quadrature += gains.drive.quadrature;
  block_gains_.drive.steering += gains.drive.steering;
  block_gains_.drive.compensation += gains.drive.compensation;
  if (next_in_block_ < rows_per_block_) return;
  const double rows = static_cast<double>(rows_per_block_);
  block_.orbit.a /= rows;
  block_.orbit.b /= rows;
  block_.orbit.theta /= rows;
  block_.orbit.phi /= rows;
  block_.row /= rows;
  block_gains_.reference_frequency /= rows;
  block_gains_.beta /= rows;
  block_gains_.alpha /= rows;
  block_gains_.virtual_rate /= rows;
  block_gains_.compensation.gain1 /= rows;
  block_gains_.compensation.gain2 /= rows;
  block_gains_.drive.sustain /= rows;
  block_gains_.drive.quadrature /= rows;
  block_gains_.drive.steering /= rows;
  block_gains_.drive.compensation /= rows;
}

void LogImporter::addSample(const LogRow& row) {
  if (next_in_block_ == 0) {
    samples_.x.clear();
    samples_.y.clear();
    samples_.reference_phase =
        has(Quantity::kReferencePhase) ? valueOf(row, Quantity::kReferencePhase) : reference_phase_;
    block_.row.setZero();
  }
  samples_.x.push_back(valueOf(row, Quantity::kX));
  samples_.y.push_back(valueOf(row, Quantity::kY));
  block_.row += row / static_cast<double>(rows_per_block_);
  reference_phase_ = wrapToPi(reference_phase_ + valueOf(row, Quantity::kOmega) * clock_->period());
  if (++next_in_block_ < rows_per_block_) return;
  next_in_block_ = 0;
  finishSamples();
}

void LogImporter::finishSamples() {
  samples_.reference_frequency = valueOf(block_.row, Quantity::kOmega);
  const Envelope envelope = demodulator_->process(samples_);
  if (blocks_to_settle_ > 0) {
    --blocks_to_settle_;
    counts_.left_over_rows += static_cast<std::uint64_t>(rows_per_block_);
    return;
  }
  Orbit orbit = orbitFromEnvelope(envelope);
  orbit.phi += options_.phi_offset;
  block_.orbit = onBranch(orbit);
  if (!has(Quantity::kReferencePhase)) block_.orbit.phi = -0.5 * kPi;
  const double duration = static_cast<double>(rows_per_block_) * clock_->period();
  trackRate(block_.orbit, duration);
  block_gains_ = ControlGains{};
  driveOf(block_.row, block_.orbit, duration, groupDelay(), block_gains_);
  last_ = block_;
  emit();
}

bool LogImporter::locked(const Orbit& orbit) const {
  return orbit.a > 0.0 && orbit.a >= minimum_amplitude_ &&
         std::abs(orbit.b) < kLockedQuadrature * orbit.a &&
         std::abs(orbit.phi + 0.5 * kPi) < kLockedPhase;
}

void LogImporter::emit() {
  const std::int64_t sequence = row_index_ / rows_per_block_;
  OrbitalElements elements;
  elements.stamp.session = options_.session;
  elements.stamp.sequence = static_cast<std::uint64_t>(sequence);
  elements.stamp.end_ns = origin_ns_ + (sequence - first_block_) * duration_ns_;
  elements.stamp.duration_ns = duration_ns_;
  elements.group_delay =
      has(Quantity::kGroupDelay) ? valueOf(block_.row, Quantity::kGroupDelay) : groupDelay();
  elements.orbit = block_.orbit;
  elements.theta_rate = theta_rate_;
  elements.angle = block_.orbit.theta;
  elements.angle_rate = theta_rate_;
  // If the log has a flag, only the flag counts; one unusable row makes its block unusable.
  const bool usable = has(Quantity::kUsable)
                          ? valueOf(block_.row, Quantity::kUsable) > 1.0 - 1e-9
                          : locked(block_.orbit) && block_gains_.reference_frequency > 0.0;
  LoopStatus status;
  status.amplitude_locked = status.quadrature_locked = status.phase_locked = usable;
  elements.status = block_gains_.status = status;
  block_gains_.stamp = elements.stamp;
  if (demodulator_) {
    block_gains_.reference_phase = samples_.reference_phase;
  } else if (has(Quantity::kReferencePhase)) {
    block_gains_.reference_phase = valueOf(block_.row, Quantity::kReferencePhase);
  }
  ++counts_.blocks;
  if (!usable) {
    ++counts_.unusable_blocks;
  } else {
    const std::uint64_t good = counts_.blocks - counts_.unusable_blocks;
    const double theta = elements.orbit.theta;
    counts_.lowest_theta = good == 1 ? theta : std::min(counts_.lowest_theta, theta);
    counts_.highest_theta = good == 1 ? theta : std::max(counts_.highest_theta, theta);
    counts_.mean_beta += (block_gains_.beta - counts_.mean_beta) / static_cast<double>(good);
  }
  (*sink_)(elements, block_gains_);
}

const ImportCounts& LogImporter::run(const Sink& sink, const Progress& progress) {
  sink_ = &sink;
  const auto takeOrNote = [this](const LogRow& row, const std::string& place) {
    try {
      take(row, place);
    } catch (const RowError& error) {
      note(error);
    }
  };
  for (const HeadRow& each : head_) takeOrNote(each.row, each.place);
  LogRow row;
  while (nextGood(row, [this](const RowError& error) { note(error); })) {
    takeOrNote(row, rows_.place());
    if (rows_.count() % 64 == 0 && progress) progress(rows_.done(), rows_.size());
  }
  breakBlock();
  counts_.rows = rows_.count();
  return counts_;
}

}  // namespace cvg
