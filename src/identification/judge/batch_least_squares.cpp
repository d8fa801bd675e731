#include "ring_gyro/identification/judge/batch_least_squares.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <stdexcept>

#include "ring_gyro/demodulation/orbit.h"
#include "ring_gyro/identification/filter/extended_prior.h"

namespace cvg {
namespace {

constexpr int kMeasuredPasses = 3;  // the first ones, with derivatives along the measured envelope
constexpr int kMostPasses = 20;
constexpr double kConverged = 1e-4;  // step in standard deviations

}  // namespace

/// A series of samples without a break; its initial envelope is four more unknowns.
struct BatchLeastSquares::Piece {
  std::size_t begin = 0;
  std::size_t end = 0;
  Eigen::Vector4d start;                    // estimate of the initial envelope
  EnvelopeSensitivity start_by_parameters;  // derivative of the best start by the parameters
  Eigen::Vector4d start_offset;             // from the best start at these parameters
};

/// Normal equations of the scaled parameters, with the initial envelopes eliminated.
struct BatchLeastSquares::Normal {
  ExtendedMatrix matrix;
  ExtendedVector vector;
  double chi_square = 0.0;
  int residuals = 0;
};

BatchLeastSquares::BatchLeastSquares(const DeviceKnowledge& device,
                                     const ExtendedParameters& parameters,
                                     const ConverterParameters& converter)
    : parameters_(checked(parameters, "extended")),
      model_(ExtendedState(device, parameters)),
      period_blocks_(static_cast<std::size_t>(parameters.periodBlocks(converter))),
      block_duration_(converter.blockDuration()),
      sample_variance_(parameters.noise_density * parameters.noise_density / block_duration_),
      chain_(converter.blockDurationNanoseconds()) {}

void BatchLeastSquares::add(const OrbitalElements& elements, const ControlGains& gains,
                            double rotation_rate) {
  if (chain_.admit(elements, gains, rotation_rate) != BlockUse::kUsable) {
    chained_ = false;
    return;
  }
  const BlockChain::Block& now = chain_.last();
  chained_ = chained_ && chain_.follows();
  if (samples_.size() < period_blocks_) {
    first_look_.add(now.orbit, now.drive, now.reference_frequency);
  }
  Sample sample;
  sample.starts_piece = !chained_;
  sample.measured = realParts(envelopeFromOrbit(now.orbit));
  sample.durations = {0.0, 0.0};
  sample.middles = {0.0, 0.0};
  if (chained_) {
    const std::array<ChainSegment, 2> segments = chain_.segments();
    for (std::size_t k = 0; k < 2; ++k) {
      const ChainSegment& segment = segments[k];
      sample.durations[k] = segment.duration;
      sample.middles[k] = segment.middle;
      sample.inputs[k] = segment.input;
    }
  }
  samples_.push_back(sample);
  chained_ = true;
}

void BatchLeastSquares::accumulatePiece(const ExtendedVector& linear, const ExtendedVector& scale,
                                        bool at_measured, Piece& piece, Normal& normal) const {
  const Eigen::Index size = model_.state().size();
  const Eigen::Index parameters = size - 4;
  const int cubic = model_.state().layout().pickoff_cubic;
  Eigen::Vector4d envelope = piece.start;
  EnvelopeSensitivity sensitivity = EnvelopeSensitivity::Identity(4, size);
  EnvelopeStep step;
  // Normal equations of the whole state: initial envelope, then parameters.
  ExtendedMatrix matrix = ExtendedMatrix::Zero(size, size);
  ExtendedVector vector = ExtendedVector::Zero(size);

  Eigen::Vector4d residual_sum = Eigen::Vector4d::Zero();
  EnvelopeSensitivity sensitivity_sum = EnvelopeSensitivity::Zero(4, size);
  std::size_t count = 0;
  for (std::size_t n = piece.begin; n < piece.end; ++n) {
    const Sample& sample = samples_[n];
    for (std::size_t k = 0; n > piece.begin && k < 2; ++k) {
      if (sample.durations[k] <= 0.0) continue;
      if (at_measured) {
        const Eigen::Vector4d& before = samples_[n - 1].measured;
        const Eigen::Vector4d middle =
            model_.undistorted(before + sample.middles[k] * (sample.measured - before), linear);
        model_.step(envelope, linear, {middle, linear}, sample.inputs[k], sample.durations[k],
                    step);
      } else {
        model_.step(envelope, linear, {envelope, linear}, sample.inputs[k], sample.durations[k],
                    step);
      }
      envelope = step.after;
      sensitivity = (step.transition * sensitivity).eval();
      sensitivity.rightCols(parameters) += step.by_parameters;
    }
    // Compare the prediction as the pick-offs show it with the measurement. In the first passes the
    // prediction may be far off; then remove the distortion from the measurement instead.
    if (at_measured && cubic >= 0) {
      const Eigen::Vector4d point = model_.undistorted(sample.measured, linear);
      const EnvelopeModel::Measurement shown = model_.measure(point, linear);
      residual_sum += shown.by_envelope * (point - envelope);
      sensitivity_sum += shown.by_envelope * sensitivity;
      sensitivity_sum.col(cubic) += shown.by_cubic;
    } else {
      const EnvelopeModel::Measurement shown = model_.measure(envelope, linear);
      residual_sum += sample.measured - shown.value;
      sensitivity_sum += shown.by_envelope * sensitivity;
      if (cubic >= 0) sensitivity_sum.col(cubic) += shown.by_cubic;
    }
    ++count;
    if (count == period_blocks_ || n + 1 == piece.end) {
      const double weight = 1.0 / (static_cast<double>(count) * sample_variance_);
      const EnvelopeSensitivity rows = sensitivity_sum * scale.asDiagonal();
      matrix.noalias() += weight * rows.transpose() * rows;
      vector.noalias() += weight * rows.transpose() * residual_sum;
      normal.chi_square += weight * residual_sum.squaredNorm();
      normal.residuals += 4;
      residual_sum.setZero();
      sensitivity_sum.setZero();
      count = 0;
    }
  }

  const Eigen::Matrix4d inverse = matrix.topLeftCorner<4, 4>().inverse();
  piece.start_by_parameters = -inverse * matrix.topRightCorner(4, parameters);
  piece.start_offset = inverse * vector.head<4>();
  normal.matrix += matrix.bottomRightCorner(parameters, parameters) +
                   matrix.bottomLeftCorner(parameters, 4) * piece.start_by_parameters;
  normal.vector +=
      vector.tail(parameters) - matrix.bottomLeftCorner(parameters, 4) * piece.start_offset;
}

BatchEstimate BatchLeastSquares::solve() const {
  const ExtendedState& state = model_.state();
  const Eigen::Index size = state.size();
  const Eigen::Index parameters = size - 4;
  std::vector<Piece> pieces;
  for (std::size_t n = 0; n < samples_.size(); ++n) {
    if (samples_[n].starts_piece) {
      Piece piece;
      piece.begin = n;
      piece.start = samples_[n].measured;
      pieces.push_back(piece);
    }
    pieces.back().end = n + 1;
  }
  if (samples_.size() < period_blocks_) {
    throw std::runtime_error("batch least squares: " + std::to_string(samples_.size()) +
                             " usable blocks, at least one period of " +
                             std::to_string(period_blocks_) + " is needed");
  }

  const FirstLook look = first_look_.look(block_duration_, state.device().decayRate());
  const ExtendedVector guess = startValue(state, parameters_, look);
  if (!(guess[state.layout().drive_gain] > 0.0)) {
    throw std::runtime_error(
        "batch least squares: the drive of the first period does not sustain the orbit; set "
        "initial_drive_gain");
  }
  const ExtendedVector sigma = priorSigma(state, parameters_, guess);
  const ExtendedMatrix slope = state.linearByPhysical(guess);
  ExtendedVector scale = slope.cwiseAbs() * sigma;
  scale.head<4>().setOnes();
  const ExtendedVector parameter_scale = scale.tail(parameters);
  const ExtendedMatrix prior_slope =
      parameter_scale.cwiseInverse().asDiagonal() * slope.bottomRightCorner(parameters, parameters);
  const ExtendedMatrix prior =
      prior_slope * sigma.tail(parameters).cwiseAbs2().asDiagonal() * prior_slope.transpose();
  const ExtendedMatrix prior_information = prior.inverse();

  const ExtendedVector first = state.linear(guess);
  ExtendedVector linear = first;
  BatchEstimate estimate;
  ExtendedMatrix covariance;
  for (int pass = 0; pass < kMostPasses; ++pass) {
    Normal normal;
    normal.matrix = prior_information;
    normal.vector =
        prior_information * (first - linear).tail(parameters).cwiseQuotient(parameter_scale);
    for (Piece& piece : pieces) {
      accumulatePiece(linear, scale, pass < kMeasuredPasses, piece, normal);
    }
    const Eigen::LDLT<ExtendedMatrix> solver(normal.matrix);
    const ExtendedVector change = solver.solve(normal.vector);
    if (!change.allFinite()) break;
    linear.tail(parameters) += change.cwiseProduct(parameter_scale);
    for (Piece& piece : pieces) {
      piece.start += piece.start_offset + piece.start_by_parameters * change;
    }
    estimate.passes = pass + 1;
    estimate.chi_square = normal.chi_square;
    estimate.residuals = normal.residuals;
    covariance = solver.solve(ExtendedMatrix::Identity(parameters, parameters));
    // Compare the step with the standard deviations of the estimate.
    if (pass > kMeasuredPasses && change.dot(normal.matrix * change) < kConverged * kConverged) {
      estimate.converged = true;
      break;
    }
  }
  linear.head<4>() = pieces.front().start;
  estimate.value = state.physical(linear);
  ExtendedMatrix whole = ExtendedMatrix::Zero(size, size);
  whole.bottomRightCorner(parameters, parameters) =
      (parameter_scale * parameter_scale.transpose()).cwiseProduct(covariance);
  const ExtendedMatrix by_linear = state.physicalByLinear(linear);
  estimate.covariance = by_linear * whole * by_linear.transpose();
  return estimate;
}

}  // namespace cvg
