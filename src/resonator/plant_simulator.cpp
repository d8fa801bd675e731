#include "ring_gyro/resonator/plant_simulator.h"

#include <array>
#include <cmath>
#include <complex>
#include <stdexcept>

#include "ring_gyro/common/vector_kernels.h"
#include "ring_gyro/resonator/converter.h"
#include "ring_gyro/resonator/normal_source.h"
#include "ring_gyro/resonator/ring_resonator.h"
#include "ring_gyro/resonator/sampled_resonator.h"

namespace ring_gyro {
namespace {

using Complex = std::complex<double>;

Eigen::Vector2cd delayed(const Eigen::Vector2cd& envelope, const Eigen::Vector2d& delays) {
  return {envelope[0] * std::polar(1.0, -delays[0]), envelope[1] * std::polar(1.0, -delays[1])};
}

PlantParameters withTuning(PlantParameters parameters) {
  parameters.resonator = parameters.resonator.tuned();
  return parameters;
}

}  // namespace

class PlantSimulator::Implementation {
 public:
  Implementation(const PlantParameters& parameters, const ConverterParameters& converter,
                 std::uint64_t seed, std::uint32_t session, std::int64_t start_ns)
      : parameters_(withTuning(parameters)),
        converter_(converter),
        resonator_(parameters_.resonator),
        sampled_(parameters_.resonator, converter.samplePeriod()),
        rotation_(parameters.rotation),
        noise_(seed),
        adc_(parameters.sense.adc_bits, parameters.sense.adc_range),
        dac_(parameters.drive.dac_bits, parameters.drive.dac_range),
        drive_gain_(parameters.drive.axes.gainMatrix()),
        samples_(converter.block_samples),
        displacement_(static_cast<Eigen::Index>(
                          paddedToLanes(static_cast<std::size_t>(converter.block_samples))),
                      2) {
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
    block_.x.resize(static_cast<std::size_t>(samples_));
    block_.y.resize(static_cast<std::size_t>(samples_));

    const double w0 = parameters_.resonator.angularFrequency();
    const double h = converter.samplePeriod();
    const Eigen::Index padded = displacement_.rows();
    displacement_.setZero();
    cosine_.resize(padded);
    sine_.resize(padded);
    share_.resize(padded);
    for (Eigen::Index j = 0; j < padded; ++j) {
      const double turn = w0 * h * static_cast<double>(j);
      cosine_[j] = std::cos(turn);
      sine_[j] = std::sin(turn);
      share_[j] = static_cast<double>(j) / static_cast<double>(samples_);
    }
    sample_sigma_ = std::sqrt(0.5 * converter.sample_rate);
    const bool hold = parameters.drive.zero_order_hold;
    const double drive_density = hold ? 0.0 : parameters.drive.noise_density;
    force_density_ = std::hypot(parameters.resonator.thermal_noise_density, drive_density);
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
    command_.reference_phase = end_phase_;
    return advance();
  }

  PlantTruth truth() const {
    const ResonatorParameters& p = parameters_.resonator;
    PlantTruth truth;
    truth.stamp = block_.stamp;
    truth.envelope =
        resonator_.analyticDisplacement(force_envelope_, end_phase_, command_.reference_frequency) *
        std::polar(1.0, -end_phase_);
    truth.rotation_rate = rotation_rate_;
    truth.rotation_angle = rotation_.meanRate(0.0, time()) * time() + table_angle_;
    const double temperature = p.temperature_rate * time();
    truth.natural_frequency =
        p.natural_frequency * (1.0 + p.frequency_temperature_coefficient * temperature);
    truth.quality_factor =
        p.quality_factor * (1.0 + p.quality_temperature_coefficient * temperature);
    truth.gamma1 = p.gamma1;
    truth.gamma2 = p.gamma2;
    truth.mu1 = p.mu1;
    truth.mu2 = p.mu2;
    truth.drive_gain = resonator_.driveGain();
    return truth;
  }

 private:
  double time() const { return 1e-9 * static_cast<double>(block_.stamp.end_ns - start_ns_); }

  const DisplacementBlock& advance() {
    const double begin = time();
    block_.stamp.end_ns += block_.stamp.duration_ns;
    const double duration = block_.stamp.duration();
    if (begun_) ++block_.stamp.sequence;
    begun_ = true;
    rotation_rate_ = rotation_.meanRate(begin, begin + duration) + command_.table_rate;
    table_angle_ += command_.table_rate * duration;
    resonator_.setConditions(rotation_rate_, parameters_.resonator.temperature_rate * begin);

    block_.drive_answers_sequence = command_.answers_sequence;
    block_.reference_phase = command_.reference_phase;
    block_.reference_frequency = command_.reference_frequency;
    end_phase_ =
        std::remainder(command_.reference_phase + command_.reference_frequency * duration, kTwoPi);

    force_envelope_ = realisedDrive();
    const bool exact = !parameters_.drive.zero_order_hold &&
                       parameters_.resonator.cubic_stiffness == 0.0 &&
                       rotation_.isConstant(begin, begin + duration);
    if (exact) {
      moveBlock(duration);
    } else {
      moveSamples(begin);
    }
    kickByNoise(duration);
    sense();
    return block_;
  }

  // Drive that reaches the ring from an ideal modulator. A cubic error acts on the fundamental by
  // 3/4 of itself; its third harmonic is far from the resonance.
  Eigen::Vector2cd realisedDrive() const {
    const DriveParameters& p = parameters_.drive;
    Eigen::Vector2cd envelope = command_.envelope;
    if (p.cubic != 0.0 && !p.zero_order_hold) {
      for (Complex& axis : envelope) axis *= 1.0 + 0.75 * p.cubic * std::norm(axis);
    }
    return drive_gain_.cast<Complex>() * delayed(envelope, p.axes.phaseDelays());
  }

  void moveBlock(double duration) {
    const BlockMotion& motion = resonator_.propagate(force_envelope_, command_.reference_phase,
                                                     command_.reference_frequency, duration);
    const Eigen::Vector2d delays = parameters_.sense.axes.phaseDelays();
    for (int axis = 0; axis < 2; ++axis) {
      const Complex delay = std::polar(1.0, -delays[axis]);
      std::array<double, BlockMotion::kMaxTerms> real;
      std::array<double, BlockMotion::kMaxTerms> imaginary;
      for (int k = 0; k < motion.terms; ++k) {
        const Complex coefficient = motion.coefficients[k][axis] * delay;
        real[k] = coefficient.real();
        imaginary[k] = coefficient.imag();
      }
      samplePhasorSeries(real.data(), imaginary.data(), motion.terms, share_.data(), cosine_.data(),
                         sine_.data(), static_cast<std::size_t>(share_.size()),
                         displacement_.col(axis).data());
    }
  }

  void moveSamples(double begin) {
    sampled_.setLinear(resonator_);
    const DriveParameters& p = parameters_.drive;
    const Eigen::Vector2d delays = parameters_.sense.axes.phaseDelays();
    const double w0 = parameters_.resonator.angularFrequency();
    const double h = converter_.samplePeriod();
    const auto extra_rate = [&](double t) { return rotation_.rate(t) + command_.table_rate - rotation_rate_; };
    const Eigen::Vector2cd converted = delayed(command_.envelope, p.axes.phaseDelays());
    Eigen::Vector4d state = resonator_.state();
    SampleDrive drive;
    drive.held = p.zero_order_hold;
    drive.envelope = force_envelope_;
    drive.frequency = command_.reference_frequency;
    for (Eigen::Index j = 0; j < samples_; ++j) {
      const double offset = h * static_cast<double>(j);
      drive.phase = command_.reference_phase + command_.reference_frequency * offset;
      if (drive.held) drive.value = heldDrive(converted, drive.phase);
      for (int axis = 0; axis < 2; ++axis) {
        displacement_(j, axis) =
            std::cos(delays[axis]) * state[axis] - std::sin(delays[axis]) * state[axis + 2] / w0;
      }
      state = sampled_.step(resonator_, state, drive, begin + offset, extra_rate);
    }
    resonator_.setState(state);
  }

  Eigen::Vector2d heldDrive(const Eigen::Vector2cd& envelope, double phase) {
    const DriveParameters& p = parameters_.drive;
    const Complex turn = std::polar(1.0, phase);
    Eigen::Vector2d volts;
    for (int axis = 0; axis < 2; ++axis) {
      std::uint32_t saturated = 0;
      double value = dac_.convert((envelope[axis] * turn).real(), saturated);
      if (p.noise_density > 0.0) value += p.noise_density * sample_sigma_ * noise_.next();
      volts[axis] = value * (1.0 + p.cubic * value * value);
    }
    return drive_gain_ * volts;
  }

  // White force over a block, spread by the vibration over displacement and velocity, less what the
  // damping takes of it until the block's end.
  void kickByNoise(double duration) {
    if (force_density_ == 0.0) return;
    const double decay = 2.0 * parameters_.resonator.decayRate();
    const double effective = -std::expm1(-decay * duration) / decay;
    const double velocity = 0.5 * resonator_.driveGain() * force_density_ * std::sqrt(effective);
    const double displacement = velocity / parameters_.resonator.angularFrequency();
    resonator_.addToState({displacement * noise_.next(), displacement * noise_.next(),
                           velocity * noise_.next(), velocity * noise_.next()});
  }

  void sense() {
    const SenseParameters& p = parameters_.sense;
    Eigen::Map<Eigen::ArrayXd> x(block_.x.data(), samples_);
    Eigen::Map<Eigen::ArrayXd> y(block_.y.data(), samples_);
    const auto first = displacement_.col(0).head(samples_);
    const auto second = displacement_.col(1).head(samples_);
    x = first;
    y = std::sin(p.axes.misalignment) * first + std::cos(p.axes.misalignment) * second;
    // The gap of an electrode is that in its own direction.
    if (p.cubic != 0.0) {
      x += p.cubic * x.cube();
      y += p.cubic * y.cube();
    }
    x *= p.axes.gain_x;
    y *= p.axes.gain_y;
    if (p.feedthrough != 0.0) addFeedthrough(x, y);
    if (p.noise_density > 0.0) {
      noise_.addTo(block_.x.data(), block_.x.size(), p.noise_density * sample_sigma_);
      noise_.addTo(block_.y.data(), block_.y.size(), p.noise_density * sample_sigma_);
    }
    block_.saturated_samples = 0;
    if (!adc_.ideal()) {
      for (double& sample : block_.x) sample = adc_.convert(sample, block_.saturated_samples);
      for (double& sample : block_.y) sample = adc_.convert(sample, block_.saturated_samples);
    }
  }

  void addFeedthrough(Eigen::Map<Eigen::ArrayXd>& x, Eigen::Map<Eigen::ArrayXd>& y) const {
    const Eigen::Vector2cd leak = parameters_.sense.feedthrough * command_.envelope;
    const double step = command_.reference_frequency * converter_.samplePeriod();
    for (Eigen::Index j = 0; j < samples_; ++j) {
      const Complex turn =
          std::polar(1.0, command_.reference_phase + step * static_cast<double>(j));
      x[j] += (leak[0] * turn).real();
      y[j] += (leak[1] * turn).real();
    }
  }

  PlantParameters parameters_;
  ConverterParameters converter_;
  RingResonator resonator_;
  SampledResonator sampled_;
  RotationProfile rotation_;
  NormalSource noise_;
  Converter adc_;
  Converter dac_;
  Eigen::Matrix2d drive_gain_;
  Eigen::Index samples_;
  Eigen::Array<double, Eigen::Dynamic, 2> displacement_;
  Eigen::ArrayXd cosine_;  // of w0 at the sample times of a block
  Eigen::ArrayXd sine_;
  Eigen::ArrayXd share_;        // of the block at the sample times
  double sample_sigma_ = 0.0;   // of white noise with one-sided density 1, per sample
  double force_density_ = 0.0;  // of force noise, as drive [V/sqrt(Hz)]
  std::int64_t start_ns_ = 0;
  bool begun_ = false;
  DriveCommand command_;
  Eigen::Vector2cd force_envelope_ = Eigen::Vector2cd::Zero();
  double end_phase_ = 0.0;
  double rotation_rate_ = 0.0;
  double table_angle_ = 0.0;  // through which the rate table has turned [rad]
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
PlantTruth PlantSimulator::truth() const { return implementation_->truth(); }

}  // namespace ring_gyro
