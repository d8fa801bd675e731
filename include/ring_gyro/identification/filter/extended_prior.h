#pragma once

#include "ring_gyro/identification/filter/first_look.h"
#include "ring_gyro/identification/model/extended_state.h"

namespace cvg {

/// Physical coordinates to start from; the envelope is zero.
ExtendedVector startValue(const ExtendedState& state, const ExtendedParameters& parameters,
                          const FirstLook& look);

/// Standard deviations of the parameters before any data, physical coordinates, about `value`; of
/// the envelope zero.
ExtendedVector priorSigma(const ExtendedState& state, const ExtendedParameters& parameters,
                          const ExtendedVector& value);

/// Random walks of the parameters, physical coordinates [unit/sqrt(s)].
ExtendedVector parameterWalk(const ExtendedState& state, const ExtendedParameters& parameters,
                             const ExtendedVector& value);

}  // namespace cvg
