#include "ring_gyro/resonator/plant_simulator.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <stdexcept>

#include "ring_gyro/common/aligned_vector.h"
#include "ring_gyro/common/vector_kernels.h"
#include "ring_gyro/resonator/converter.h"
#include "ring_gyro/resonator/normal_source.h"
#include "ring_gyro/resonator/ring_resonator.h"
#include "ring_gyro/resonator/sampled_resonator.h"

namespace cvg {
namespace {

using Complex = std::complex<double>;

// e^{-i delay} of both axes.
Eigen::Vector2cd delayPhasors(const AxisErrors& axes) {
  const Eigen::Vector2d delays = axes.phaseDelays();
  return {std::polar(1.0, -delays[0]), std::polar(1.0, -delays[1])};
}

PlantParameters checkedAndTuned(PlantParameters parameters) {
  checked(parameters.resonator, "resonator");
  checked(parameters.sense, "sense");
  checked(parameters.drive, "drive");
  const double bias = parameters.resonator.bias_voltage;
  if (bias > 0.0 && parameters.drive.bias_voltage > 0.0 && bias != parameters.drive.bias_voltage) {
    throw std::invalid_argument(
        "drive: bias_voltage = " + std::to_string(parameters.drive.bias_voltage) +
        " V is not the resonator's bias_voltage = " + std::to_string(bias) +
        " V; the drive electrodes have one bias: give both the same");
  }
  parameters.resonator = parameters.resonator.tuned();
  return parameters;
}

}  // namespace

class PlantSimulator::Implementation {
 public:
  Implementation(const PlantParameters& parameters, const ConverterParameters& converter,
                 std::uint64_t seed, std::uint32_t session, std::int64_t start_ns)
      : parameters_(checkedAndTuned(parameters)),
        converter_(checked(converter, "converter")),
        resonator_(parameters_.resonator),
        sampled_(parameters_.resonator, parameters.drive.gap_cubic, converter.samplePeriod()),
        rotation_(parameters.rotation),
        noise_(seed),
        adc_(parameters.sense.adc_bits, parameters.sense.adc_range),
        dac_(parameters.drive.dac_bits, parameters.drive.dac_range),
        sense_alignment_(parameters.sense.axes.alignmentMatrix()),
        sense_scale_(Eigen::Vector2d(parameters.sense.axes.gain_x, parameters.sense.axes.gain_y)
                         .asDiagonal()),
        drive_gain_(parameters.drive.axes.gainMatrix()),
        sense_delay_(delayPhasors(parameters.sense.axes)),
        drive_delay_(delayPhasors(parameters.drive.axes)),
        samples_(static_cast<std::size_t>(converter.block_samples)),
        padded_(paddedToLanes(samples_)) {
    if (parameters.drive.dac_bits > 0 && !parameters.drive.zero_order_hold) {
      throw std::invalid_argument("drive: dac_bits = " + std::to_string(parameters.drive.dac_bits) +
                                  " needs a held drive; set zero_order_hold: true, or dac_bits: 0");
    }
    if (start_ns <= 0) {
      throw std::invalid_argument(
          "run: start_time must be above zero; a zero stamp has no meaning");
    }
    block_.stamp.session = session;
    block_.stamp.duration_ns = converter.blockDurationNanoseconds();
    block_.stamp.end_ns = start_ns;
    start_ns_ = start_ns;
    block_.x.resize(samples_);
    block_.y.resize(samples_);

    const double w0 = parameters_.resonator.angularFrequency();
    const double h = converter.samplePeriod();
    x_.resize(padded_);
    y_.resize(padded_);
    drive_x_.resize(padded_);
    drive_y_.resize(padded_);
    for (std::size_t j = 0; j < padded_; ++j) {
      const double turn = w0 * h * static_cast<double>(j);
      cosine_.push_back(std::cos(turn));
      sine_.push_back(std::sin(turn));
      share_.push_back(static_cast<double>(j) / static_cast<double>(samples_));
    }
    sample_sigma_ = std::sqrt(0.5 * converter.sample_rate);
    const bool hold = parameters.drive.zero_order_hold;
    const double drive_density = hold ? 0.0 : parameters.drive.noise_density;
    force_density_ = std::hypot(parameters.resonator.thermal_noise_density, drive_density);
    const double decay = 2.0 * parameters_.resonator.decayRate();
    const double effective = -std::expm1(-decay * block_.stamp.duration()) / decay;
    velocity_kick_ = 0.5 * resonator_.driveGain() * force_density_ * std::sqrt(effective);
  }

  const DisplacementBlock& step(const DriveCommand& command) {
    if (!command.envelope.allFinite() || !std::isfinite(command.reference_phase) ||
        !std::isfinite(command.reference_frequency)) {
      throw std::domain_error("drive command that answers block " +
                              std::to_string(command.answers_sequence) +
                              " is not finite; the loops that sent it have failed");
    }
    command_ = command;
    block_.driven = true;
    return advance();
  }

  const DisplacementBlock& coast() {
    command_.reference_phase =
        wrapToPi(command_.reference_phase + command_.reference_frequency * block_.stamp.duration());
    return advance();
  }

  void setRotationRate(double rate) {
    if (!std::isfinite(rate)) {
      throw std::domain_error("rotation: a commanded rate is not finite; give a rate in rad/s");
    }
    commanded_rate_ = rate;
  }

  void setTemperature(double deviation) {
    if (!std::isfinite(deviation)) {
      throw std::domain_error("temperature: a commanded deviation is not finite; give it in K");
    }
    commanded_temperature_ = deviation;
  }

  PlantTruth truth() const {
    const ResonatorParameters& p = parameters_.resonator;
    PlantTruth truth;
    truth.stamp = block_.stamp;
    truth.envelope = resonator_.analyticDisplacement(forced_, end_turn_) * std::conj(end_turn_);
    truth.rotation_rate = rotation_rate_;
    truth.rotation_angle = rotation_.meanRate(0.0, time()) * time() + commanded_angle_;
    const double temperature = temperatureAt(time());
    truth.natural_frequency =
        p.natural_frequency * (1.0 + p.frequency_temperature_coefficient * temperature);
    truth.quality_factor =
        p.quality_factor * (1.0 + p.quality_temperature_coefficient * temperature);
    const double gamma_change = 1.0 + p.gamma_temperature_coefficient * temperature;
    truth.gamma1 = p.gamma1 * gamma_change;
    truth.gamma2 = p.gamma2 * gamma_change;
    truth.mu1 = p.mu1;
    truth.mu2 = p.mu2;
    truth.drive_gain = resonator_.driveGain();
    return truth;
  }

 private:
  double temperatureAt(double time) const {
    return parameters_.resonator.temperature_rate * time + commanded_temperature_;
  }

  double time() const { return 1e-9 * static_cast<double>(block_.stamp.end_ns - start_ns_); }

  const DisplacementBlock& advance() {
    const double begin = time();
    block_.stamp.end_ns += block_.stamp.duration_ns;
    const double duration = block_.stamp.duration();
    if (begun_) ++block_.stamp.sequence;
    begun_ = true;
    const double profile_rate = rotation_.meanRate(begin, begin + duration);
    rotation_rate_ = profile_rate + commanded_rate_;
    commanded_angle_ += commanded_rate_ * duration;
    resonator_.setConditions(rotation_rate_, temperatureAt(begin));

    block_.drive_answers_sequence = command_.answers_sequence;
    block_.reference_phase = command_.reference_phase;
    block_.reference_frequency = command_.reference_frequency;

    force_ = realisedDrive();
    forced_ = resonator_.steadyMotion(force_, command_.reference_frequency);
    const bool held = parameters_.drive.zero_order_hold;
    if (held) holdDrive();
    const bool constant = rotation_.isConstant(begin, begin + duration);
    if (constant && !held && sampled_.isLinear()) {
      moveBlock(duration);
    } else {
      if (constant && held && sampled_.canMoveHeld()) {
        moveHeld();
      } else {
        integrateSamples(begin, profile_rate);
      }
      end_turn_ = std::polar(1.0, phaseAt(samples_));
    }
    kickByNoise();
    sense();
    return block_;
  }

  // Drive that reaches the ring from an ideal modulator. 3/4 of a cubic error acts on the
  // fundamental; its third harmonic is far from the resonance.
  DriveForce realisedDrive() const {
    const DriveParameters& p = parameters_.drive;
    Envelope envelope = command_.envelope;
    if (p.cubic != 0.0) {
      for (Complex& axis : envelope) axis *= 1.0 + 0.75 * p.cubic * std::norm(axis);
    }
    const Envelope volts = envelope.cwiseProduct(drive_delay_);
    DriveForce force = Eigen::Vector2cd(drive_gain_.cast<Complex>() * volts);
    if (p.bias_voltage > 0.0) {
      // Re[F e^{i psi}]^2 = (|F|^2 + Re[F^2 e^{2 i psi}]) / 2.
      const double share = 0.25 / p.bias_voltage;
      force.constant = drive_gain_ * (share * volts.cwiseAbs2());
      force.second = drive_gain_.cast<Complex>() * (share * volts.cwiseProduct(volts));
    }
    return force;
  }

  void moveBlock(double duration) {
    const BlockMotion& motion = resonator_.propagate(forced_, command_.reference_phase, duration);
    end_turn_ = motion.end_turn;
    const PhasorSeries series = delayed(motion.series);
    samplePhasorSeries(series, share_.data(), cosine_.data(), sine_.data(), padded_, x_.data(),
                       y_.data());
    if (forced_.harmonic) return;
    // Effect of the phase delay, cos(delay) u - sin(delay) u' / w0, on the other terms.
    const double twice = motion.second_frequency / parameters_.resonator.angularFrequency();
    for (int axis = 0; axis < 2; ++axis) {
      const Complex delay = sense_delay_[axis];
      AlignedVector& samples = axis == 0 ? x_ : y_;
      for (double& sample : samples) sample += delay.real() * motion.constant[axis];
      const Complex second = motion.second[axis] * Complex(delay.real(), delay.imag() * twice);
      addPhasor(second.real(), second.imag(), motion.second_frequency * converter_.samplePeriod(),
                padded_, samples.data());
    }
  }

  PhasorSeries delayed(const PhasorSeries& series) const {
    PhasorSeries result;
    result.terms = series.terms;
    for (int k = 0; k < series.terms; ++k) {
      const Complex x = Complex(series.x_real[k], series.x_imaginary[k]) * sense_delay_[0];
      const Complex y = Complex(series.y_real[k], series.y_imaginary[k]) * sense_delay_[1];
      result.x_real[k] = x.real();
      result.x_imaginary[k] = x.imag();
      result.y_real[k] = y.real();
      result.y_imaginary[k] = y.imag();
    }
    return result;
  }

  void moveHeld() {
    sampled_.setLinear(resonator_);
    Eigen::Vector4d state = resonator_.state();
    sampled_.moveHeld(state, drive_x_.data(), drive_y_.data(), samples_,
                      parameters_.sense.axes.phaseDelays(), x_.data(), y_.data());
    resonator_.setState(state);
  }

  void integrateSamples(double begin, double profile_rate) {
    sampled_.setLinear(resonator_);
    const double w0 = parameters_.resonator.angularFrequency();
    const double h = converter_.samplePeriod();
    const auto extra_rate = [&](double t) { return rotation_.rate(t) - profile_rate; };
    Eigen::Vector4d state = resonator_.state();
    SampleDrive drive;
    drive.held = parameters_.drive.zero_order_hold;
    drive.force = force_;
    drive.forced = forced_;
    for (std::size_t j = 0; j < samples_; ++j) {
      const double offset = h * static_cast<double>(j);
      drive.phase = phaseAt(j);
      drive.next_phase = phaseAt(j + 1);
      if (drive.held) drive.value = {drive_x_[j], drive_y_[j]};
      x_[j] = sense_delay_[0].real() * state[0] + sense_delay_[0].imag() * state[2] / w0;
      y_[j] = sense_delay_[1].real() * state[1] + sense_delay_[1].imag() * state[3] / w0;
      state = sampled_.step(state, drive, begin + offset, extra_rate);
    }
    resonator_.setState(state);
  }

  double phaseAt(std::size_t sample) const {
    return command_.reference_phase +
           command_.reference_frequency * converter_.samplePeriod() * static_cast<double>(sample);
  }

  // The converter's voltages over the block, as they act on the axes of the ring.
  void holdDrive() {
    const DriveParameters& p = parameters_.drive;
    const Envelope start =
        command_.envelope.cwiseProduct(drive_delay_) * std::polar(1.0, command_.reference_phase);
    const double step = command_.reference_frequency * converter_.samplePeriod();
    std::size_t clipped = 0;
    for (int axis = 0; axis < 2; ++axis) {
      AlignedVector& volts = axis == 0 ? drive_x_ : drive_y_;
      std::fill(volts.begin(), volts.end(), 0.0);
      addPhasor(start[axis].real(), start[axis].imag(), step, padded_, volts.data());
      // Padding after the block must not be clipped.
      std::fill(volts.data() + samples_, volts.data() + padded_, 0.0);
      clipped += dac_.convert(volts.data(), padded_);
      if (p.noise_density > 0.0) {
        noise_.addTo(volts.data(), samples_, p.noise_density * sample_sigma_);
      }
    }
    block_.clipped_drive_samples = static_cast<std::uint32_t>(clipped);
    const double square = p.bias_voltage > 0.0 ? 0.5 / p.bias_voltage : 0.0;
    if (p.cubic != 0.0 || square != 0.0 || !drive_gain_.isIdentity(0.0)) {
      applyAxisErrors({p.cubic, square, drive_gain_.data()}, padded_, drive_x_.data(),
                      drive_y_.data());
    }
  }

  // Effect of a white force over a block: the vibration distributes it over displacement and
  // velocity, and the damping reduces it until the block's end.
  void kickByNoise() {
    if (force_density_ == 0.0) return;
    const double velocity = velocity_kick_;
    const double displacement = velocity / parameters_.resonator.angularFrequency();
    resonator_.addToState({displacement * noise_.next(), displacement * noise_.next(),
                           velocity * noise_.next(), velocity * noise_.next()});
  }

  void sense() {
    const SenseParameters& p = parameters_.sense;
    if (p.axes.misalignment != 0.0) {
      applyAxisErrors({0.0, 0.0, sense_alignment_.data()}, padded_, x_.data(), y_.data());
    }
    // The gap of an electrode depends on the displacement in its own direction.
    if (p.cubic != 0.0 || !sense_scale_.isIdentity(0.0)) {
      applyAxisErrors({p.cubic, 0.0, sense_scale_.data()}, padded_, x_.data(), y_.data());
    }
    if (p.feedthrough != 0.0) addFeedthrough();
    const double sigma = p.noise_density * sample_sigma_;
    block_.saturated_samples = 0;
    if (adc_.ideal() && sigma > 0.0) {
      noise_.addTo(x_.data(), samples_, sigma, block_.x.data());
      noise_.addTo(y_.data(), samples_, sigma, block_.y.data());
      return;
    }
    if (sigma > 0.0) {
      noise_.addTo(x_.data(), samples_, sigma);
      noise_.addTo(y_.data(), samples_, sigma);
    }
    if (!adc_.ideal()) {
      // Padding after the block must not saturate.
      std::fill(x_.data() + samples_, x_.data() + padded_, 0.0);
      std::fill(y_.data() + samples_, y_.data() + padded_, 0.0);
      block_.saturated_samples = static_cast<std::uint32_t>(adc_.convert(x_.data(), padded_) +
                                                            adc_.convert(y_.data(), padded_));
    }
    std::copy_n(x_.data(), samples_, block_.x.data());
    std::copy_n(y_.data(), samples_, block_.y.data());
  }

  void addFeedthrough() {
    const Envelope leak = parameters_.sense.feedthrough * command_.envelope *
                          std::polar(1.0, command_.reference_phase);
    const double step = command_.reference_frequency * converter_.samplePeriod();
    addPhasor(leak[0].real(), leak[0].imag(), step, padded_, x_.data());
    addPhasor(leak[1].real(), leak[1].imag(), step, padded_, y_.data());
  }

  PlantParameters parameters_;
  ConverterParameters converter_;
  RingResonator resonator_;
  SampledResonator sampled_;
  RotationProfile rotation_;
  NormalSource noise_;
  Converter adc_;
  Converter dac_;
  Eigen::Matrix2d sense_alignment_;
  Eigen::Matrix2d sense_scale_;
  Eigen::Matrix2d drive_gain_;
  Eigen::Vector2cd sense_delay_;
  Eigen::Vector2cd drive_delay_;
  std::size_t samples_;  // of a block
  std::size_t padded_;   // to whole lanes
  AlignedVector x_;      // displacements, then the output of the electronics
  AlignedVector y_;
  AlignedVector drive_x_;  // held
  AlignedVector drive_y_;
  AlignedVector cosine_;  // of w0 at the sample times of a block
  AlignedVector sine_;
  AlignedVector share_;         // of the block at the sample times
  double sample_sigma_ = 0.0;   // of white noise with one-sided density 1, per sample
  double force_density_ = 0.0;  // of force noise, as drive [V/sqrt(Hz)]
  double velocity_kick_ = 0.0;  // of it over a block, each quadrature [V/s]
  std::int64_t start_ns_ = 0;
  bool begun_ = false;
  DriveCommand command_;
  DriveForce force_;
  ForcedMotion forced_;
  Complex end_turn_{1.0, 0.0};  // e^{i psi} of the NCO at the end of the block
  double rotation_rate_ = 0.0;
  double commanded_rate_ = 0.0;
  double commanded_angle_ = 0.0;
  double commanded_temperature_ = 0.0;
  DisplacementBlock block_;
};

PlantSimulator::PlantSimulator(const PlantParameters& parameters,
                               const ConverterParameters& converter, std::uint64_t seed,
                               std::uint32_t session, std::int64_t start_ns)
    : implementation_(
          std::make_unique<Implementation>(parameters, converter, seed, session, start_ns)) {}
PlantSimulator::~PlantSimulator() = default;
PlantSimulator::PlantSimulator(PlantSimulator&&) noexcept = default;
PlantSimulator& PlantSimulator::operator=(PlantSimulator&&) noexcept = default;

const DisplacementBlock& PlantSimulator::start() { return implementation_->coast(); }
const DisplacementBlock& PlantSimulator::step(const DriveCommand& command) {
  return implementation_->step(command);
}
const DisplacementBlock& PlantSimulator::coast() { return implementation_->coast(); }
void PlantSimulator::setRotationRate(double rate) { implementation_->setRotationRate(rate); }
void PlantSimulator::setTemperature(double deviation) {
  implementation_->setTemperature(deviation);
}
PlantTruth PlantSimulator::truth() const { return implementation_->truth(); }

}  // namespace cvg
