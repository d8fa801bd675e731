#include "ring_gyro/common/sine_cosine.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace cvg {
namespace {

template <typename Vector>
void agreesWithTheLibrary() {
  constexpr int kCount = sizeof(Vector) / sizeof(double);
  for (const double scale : {1.0, 100.0, 1e4, 9.9e4, 1e9}) {
    for (int n = -2000; n <= 2000; ++n) {
      Vector angle, sine, cosine;
      for (int k = 0; k < kCount; ++k) angle[k] = scale * n / 2000.0 - 0.3 * k;
      sineCosine(angle, sine, cosine);
      for (int k = 0; k < kCount; ++k) {
        EXPECT_NEAR(sine[k], std::sin(angle[k]), 2.3e-16) << angle[k];
        EXPECT_NEAR(cosine[k], std::cos(angle[k]), 2.3e-16) << angle[k];
      }
    }
  }
}

TEST(SineCosine, AgreesWithTheLibrary) {
  agreesWithTheLibrary<FourLanes>();
  agreesWithTheLibrary<Lanes>();
}

TEST(SineCosine, OfWhatIsNotANumberIsNone) {
  FourLanes sine, cosine;
  sineCosine(FourLanes{0.5, std::numeric_limits<double>::quiet_NaN(), 1e300, 0.0}, sine, cosine);
  EXPECT_TRUE(std::isnan(sine[1]));
  EXPECT_TRUE(std::isnan(cosine[1]));
  EXPECT_EQ(sine[0], std::sin(0.5));
  EXPECT_EQ(cosine[2], std::cos(1e300));
}

}  // namespace
}  // namespace cvg
