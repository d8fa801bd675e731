#include "ring_gyro/resonator/rotation_profile.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <string>

#include "ring_gyro/common/angle.h"

namespace cvg {
namespace {

double numericMean(const RotationProfile& profile, double begin, double end) {
  const int steps = 100000;
  double sum = 0.0;
  for (int k = 0; k < steps; ++k) sum += profile.rate(begin + (k + 0.5) * (end - begin) / steps);
  return sum / steps;
}

class RotationFile : public ::testing::Test {
 protected:
  void TearDown() override { std::remove(name_.c_str()); }
  RotationParameters written(const std::string& text) {
    std::ofstream(name_) << text;
    RotationParameters parameters;
    parameters.profile = RotationShape::kFile;
    parameters.file = name_;
    return parameters;
  }
  std::string faultOf(const RotationParameters& parameters) {
    try {
      RotationProfile profile(parameters);
    } catch (const std::invalid_argument& fault) {
      return fault.what();
    }
    return "";
  }
  const std::string name_ = ::testing::TempDir() + "rotation_profile_test.csv";
};

TEST(RotationProfile, MeansAreTheMeansOfTheRates) {
  RotationParameters p;
  p.rate = 0.3;
  p.step_time = 0.51;
  p.amplitude = 2.0;
  p.frequency = 3.3;
  for (const RotationShape shape :
       {RotationShape::kConstant, RotationShape::kStep, RotationShape::kSine}) {
    p.profile = shape;
    const RotationProfile profile(p);
    EXPECT_NEAR(profile.meanRate(0.5, 0.53), numericMean(profile, 0.5, 0.53), 1e-5) << int(shape);
    EXPECT_NEAR(profile.meanRate(2.0, 3.0), numericMean(profile, 2.0, 3.0), 1e-5) << int(shape);
  }
}

TEST(RotationProfile, KnowsWhereItIsConstant) {
  RotationParameters p;
  p.profile = RotationShape::kStep;
  p.step_time = 0.5;
  const RotationProfile step(p);
  EXPECT_TRUE(step.isConstant(0.1, 0.5));
  EXPECT_FALSE(step.isConstant(0.4995, 0.5005));
  p.profile = RotationShape::kSine;
  p.amplitude = p.frequency = 1.0;
  EXPECT_FALSE(RotationProfile(p).isConstant(0.0, 0.001));
}

TEST_F(RotationFile, IsInterpolatedByStraightLines) {
  const RotationProfile profile(written("# time, rate\n0, 0\n1.0, 2.0\n3, -2\n"));
  EXPECT_NEAR(profile.rate(0.25), 0.5, 1e-15);
  EXPECT_NEAR(profile.rate(2.0), 0.0, 1e-15);
  EXPECT_NEAR(profile.rate(9.0), -2.0, 1e-15);
  EXPECT_NEAR(profile.meanRate(0.5, 2.5), numericMean(profile, 0.5, 2.5), 1e-8);
  EXPECT_NEAR(profile.meanRate(-1.0, 4.0), numericMean(profile, -1.0, 4.0), 1e-8);
}

TEST_F(RotationFile, FaultsNameFileLineAndMend) {
  EXPECT_NE(faultOf(written("0 0\n1 x\n")).find(name_ + ":2: '1 x' is not"), std::string::npos);
  EXPECT_NE(faultOf(written("0 0\n0 1\n")).find(":2:"), std::string::npos);
  EXPECT_NE(faultOf(written("# nothing\n")).find("has no rows"), std::string::npos);
  RotationParameters missing;
  missing.profile = RotationShape::kFile;
  missing.file = "/nonexistent/rates.csv";
  EXPECT_NE(faultOf(missing).find("cannot be opened"), std::string::npos);
}

}  // namespace
}  // namespace cvg
