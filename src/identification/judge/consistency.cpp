#include "ring_gyro/identification/judge/consistency.h"

#include <boost/math/distributions/chi_squared.hpp>

#include "ring_gyro/common/formatted.h"

namespace cvg {

NisBounds nisBounds(std::uint64_t updates, int degrees_of_freedom) {
  const double count = static_cast<double>(updates);
  const boost::math::chi_squared distribution(degrees_of_freedom * count);
  return {boost::math::quantile(distribution, 0.025) / count,
          boost::math::quantile(distribution, 0.975) / count};
}

void NisTally::add(double normalised_innovation_squared, bool converged) {
  ++updates;
  sum += normalised_innovation_squared;
  if (!converged) return;
  ++updates_converged;
  sum_converged += normalised_innovation_squared;
}

std::string NisTally::misfit(int degrees_of_freedom) const {
  const bool any_converged = updates_converged > 0;
  const std::uint64_t judged = any_converged ? updates_converged : updates;
  if (judged == 0) return "";
  const double mean = (any_converged ? sum_converged : sum) / static_cast<double>(judged);
  const double bound = nisBounds(judged, degrees_of_freedom).upper;
  if (mean <= kHopelessNis * bound) return "";  // false for NaN
  return formatted(
      "the data do not fit the model: mean NIS %.3g of %llu updates, at most %.3g expected; do not "
      "rely on the parameters or their sigmas: check device, noise, units and signs, and calibrate "
      "the electronics",
      mean, static_cast<unsigned long long>(judged), bound);
}

}  // namespace cvg
