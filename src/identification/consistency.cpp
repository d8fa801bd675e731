#include "ring_gyro/identification/consistency.h"

#include <boost/math/distributions/chi_squared.hpp>

#include "ring_gyro/common/formatted.h"

namespace ring_gyro {

NisBounds nisBounds(std::uint64_t updates, int degrees_of_freedom) {
  const double count = static_cast<double>(updates);
  const boost::math::chi_squared distribution(degrees_of_freedom * count);
  return {boost::math::quantile(distribution, 0.025) / count,
          boost::math::quantile(distribution, 0.975) / count};
}

std::string misfitOf(std::uint64_t updates, double nis_sum, int degrees_of_freedom) {
  if (updates == 0) return "";
  const double mean = nis_sum / static_cast<double>(updates);
  const double bound = nisBounds(updates, degrees_of_freedom).upper;
  if (mean <= kHopelessNis * bound) return "";  // false for NaN
  return formatted(
      "the data do not fit the model: mean NIS %.3g of %llu updates, at most %.3g expected; do not "
      "rely on the parameters or their sigmas: check device, noise, units and signs, and calibrate "
      "the electronics",
      mean, static_cast<unsigned long long>(updates), bound);
}

}  // namespace ring_gyro
