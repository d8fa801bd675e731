#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "ring_gyro/common/converter_parameters.h"
#include "ring_gyro/common/device_knowledge.h"
#include "ring_gyro/identification/filter/block_chain.h"
#include "ring_gyro/identification/filter/first_look.h"
#include "ring_gyro/identification/model/envelope_model.h"
#include "ring_gyro/identification/model/extended_parameters.h"

namespace cvg {

/// Result of the batch fit.
struct BatchEstimate {
  bool converged = false;
  int passes = 0;        ///< number of passes over the record
  ExtendedVector value;  ///< physical coordinates; the envelope is that at the first block
  ExtendedMatrix covariance;
  double chi_square = 0.0;  ///< of the means over update_period
  int residuals = 0;        ///< count of numbers in the sum
};

/// Least squares of the extended parameters on the whole record at once: the reference for the
/// filters. Model, means of the envelope over `update_period` and prior are the same as theirs, but
/// there is no process noise: each unbroken piece of the record is one solution of the envelope's
/// equation.
///
/// Gauss-Newton. The first passes take the derivatives along the measured envelope. The difference
/// of the measured and the predicted envelope then obeys, exactly, the equation of the predicted
/// one, driven by the errors of the parameters times the measured envelope and the drive. So one
/// pass finds the parameters from any guess, up to noise. The last passes are ordinary.
class BatchLeastSquares {
 public:
  /// Throws std::invalid_argument, naming a parameter that cannot be used.
  BatchLeastSquares(const DeviceKnowledge& device, const ExtendedParameters& parameters,
                    const ConverterParameters& converter);

  /// The next block; an unusable block ends the piece. `rotation_rate`: k Om [rad/s].
  void add(const OrbitalElements& elements, const ControlGains& gains, double rotation_rate = 0.0);

  /// Throws std::runtime_error when the record has no data to fit.
  BatchEstimate solve() const;

 private:
  struct Sample {
    bool starts_piece = false;
    Eigen::Vector4d measured;
    // Since the previous sample; a duration of zero means no step.
    std::array<double, 2> durations;
    std::array<EnvelopeInput, 2> inputs;
    std::array<double, 2> middles;
  };
  struct Piece;
  struct Normal;

  void accumulatePiece(const ExtendedVector& linear, const ExtendedVector& scale, bool at_measured,
                       Piece& piece, Normal& normal) const;

  ExtendedParameters parameters_;
  EnvelopeModel model_;
  std::size_t period_blocks_;
  double block_duration_;
  double sample_variance_;
  BlockChain chain_;
  bool chained_ = false;
  std::vector<Sample> samples_;
  FirstLookSum first_look_;
};

}  // namespace cvg
