#pragma once

#include <benchmark/benchmark.h>

#include <cstdint>

namespace cvg {

/// Predict and update of the identifier's filter against the dense filter; time per step.
void filterAgainstDense(benchmark::State& state);

/// Largest difference of any state from the dense filter in long double, over all `steps`:
/// worst_state [sigma of the reference], worst_sigma [1].
void filterAccuracy(benchmark::State& state, std::int64_t steps);

}  // namespace cvg
