#pragma once

#include <cstdint>

#include "ring_gyro/simulation/loop_configuration.h"

namespace cvg {

/// A random gyroscope with suitable loops, the same for the same index on every machine.
///
/// Random: f0 3 to 100 kHz and Q 5e3 to 1e6, both log-uniform; |gamma| up to 0.1 and |mu| up to
/// 1e-4 in any direction; ks such that sustain, quadrature and steering together use a tenth to a
/// third of the drive range of 10 V on a 1 V orbit, known to the loops within 5 %; the sense of
/// steering.
///
/// Chosen to suit: blocks of 1 ms with 10 samples per cycle or a few more; steering at
/// 3.5 xi0 w0 |gamma| or one turn in the run, whichever is faster, so that the damping cannot hold
/// the pattern; loops of 20 to 60 Hz, wide enough that frequency and quadrature follow the turning
/// pattern; a run of at least ten time constants of the ring. Noise and everything else are those
/// of `base`.
///
/// Throws std::invalid_argument with the reason when no such loops exist for the device.
LoopConfiguration randomDevice(const LoopConfiguration& base, std::uint64_t index);

}  // namespace cvg
