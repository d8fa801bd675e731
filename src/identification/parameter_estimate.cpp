#include "ring_gyro/identification/parameter_estimate.h"

#include <cmath>

namespace ring_gyro {

double ParameterEstimate::sigma(StateIndex index) const {
  return std::sqrt(covariance(index, index));
}

}  // namespace ring_gyro
