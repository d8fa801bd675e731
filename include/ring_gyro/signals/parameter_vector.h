#pragma once

#include <Eigen/Core>

namespace cvg {

/// One number per device parameter, in the order of (29): gamma1, gamma2, mu1, mu2, ks.
using ParameterVector = Eigen::Matrix<double, 5, 1>;

}  // namespace cvg
