#pragma once

#include <cstdint>
#include <string>

namespace ring_gyro {

/// Where a mean normalised innovation squared lies in 95 % of runs of a consistent filter, whose
/// expected value is the degrees of freedom of one.
struct NisBounds {
  double lower = 0.0;
  double upper = 0.0;
};
NisBounds nisBounds(std::uint64_t updates, int degrees_of_freedom = 2);

/// A mean normalised innovation squared beyond this many times its upper bound says that the data
/// are not of the model: whatever the sigmas are, they are not those of the parameters.
constexpr double kHopelessNis = 10.0;

/// Why an estimate does not fit its data, one line with the mend; empty: it may.
std::string misfitOf(std::uint64_t updates, double nis_sum, int degrees_of_freedom = 2);

}  // namespace ring_gyro
