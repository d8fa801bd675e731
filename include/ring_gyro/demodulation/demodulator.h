#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "ring_gyro/common/aligned_vector.h"
#include "ring_gyro/common/converter_parameters.h"
#include "ring_gyro/common/parameter_table.h"
#include "ring_gyro/signals/displacement_block.h"
#include "ring_gyro/signals/envelope.h"

namespace cvg {

struct DemodulationParameters {
  /// Required rejection at twice the reference frequency [dB].
  double stopband_attenuation = 120.0;

  void declare(ParameterTable& table);
};

/// Low-pass of the demodulator: a moving average over one block, whose zeros are at all frequencies
/// that would alias to DC, convolved with a Kaiser window that rejects twice the reference
/// frequency. Unit gain at DC, symmetric. `frequency`: lowest reference frequency [Hz]. Throws
/// std::invalid_argument when this sample rate does not allow the attenuation.
std::vector<double> demodulationFilter(const ConverterParameters& converter, double frequency,
                                       double attenuation);

/// Gain |H| of a filter at `frequency` [Hz] for samples at `sample_rate` [Hz].
double filterGain(const std::vector<double>& taps, double frequency, double sample_rate);

/// Orthogonal demodulation (25): samples to the envelope X = Cx - i Sx, Y = Cy - i Sy, one per
/// block.
class Demodulator {
 public:
  /// `frequency`: nominal reference frequency [Hz].
  Demodulator(const DemodulationParameters& parameters, const ConverterParameters& converter,
              double frequency);

  /// Envelope [V] valid at the block's end minus groupDelay().
  /// Samples must be finite and of the configured count.
  Envelope process(const DisplacementBlock& block);
  void reset();
  /// Blocks after a reset whose envelopes are not valid yet.
  std::int64_t settlingBlocks() const;

  /// Time from the instant at which the envelope is valid to the end of the block [s].
  double groupDelay() const;
  const std::vector<double>& taps() const { return taps_; }

 private:
  ConverterParameters converter_;
  std::vector<double> taps_;
  std::size_t samples_;    // of a block
  std::size_t earlier_;    // mixed samples kept from earlier blocks, whole lanes
  AlignedVector weights_;  // taps, with zeros before and after them
  // Re X, Im X, Re Y, Im Y: of the earlier samples, then of the kept samples of the block.
  std::array<AlignedVector, 4> mixed_;
};

}  // namespace cvg
