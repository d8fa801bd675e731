#pragma once

#include "ring_gyro/identification/filter/first_look.h"
#include "ring_gyro/identification/model/extended_state.h"

namespace cvg {

/// State to start from, physical coordinates; the envelope is zero.
ExtendedVector startValue(const ExtendedState& state, const ExtendedParameters& parameters,
                          const FirstLook& look);

/// Standard deviations of the parameters about `value` before any data, physical coordinates; those
/// of the envelope are zero.
ExtendedVector priorSigma(const ExtendedState& state, const ExtendedParameters& parameters,
                          const ExtendedVector& value);

/// Random walks of the parameters, physical coordinates [unit/sqrt(s)].
ExtendedVector parameterWalk(const ExtendedState& state, const ExtendedParameters& parameters,
                             const ExtendedVector& value);

}  // namespace cvg
