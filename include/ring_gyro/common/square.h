#pragma once

namespace cvg {

constexpr double square(double x) { return x * x; }

}  // namespace cvg
