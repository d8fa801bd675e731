#include "ring_gyro/common/converter_parameters.h"

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

namespace cvg {
namespace {

const ConverterParameters kConverter{200e3, 200};

std::string faultOf(double period) {
  try {
    kConverter.wholeBlocks(period, "extended/update_period");
    return "";
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
}

TEST(ConverterParameters, WholeBlocksOfAPeriod) {
  EXPECT_EQ(kConverter.wholeBlocks(0.001, "period"), 1);
  EXPECT_EQ(kConverter.wholeBlocks(0.1, "period"), 100);
}

TEST(ConverterParameters, NamesAPeriodThatIsNotOfWholeBlocks) {
  EXPECT_EQ(faultOf(0.0015),
            "extended/update_period = 0.0015 s must be a whole number of blocks of 0.001 s");
  EXPECT_NE(faultOf(0.0), "");
  EXPECT_NE(faultOf(-0.001), "");
  EXPECT_NE(faultOf(std::numeric_limits<double>::quiet_NaN()), "");
}

TEST(ConverterParameters, BlocksOfNoDurationAreNone) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  for (const ConverterParameters& converter :
       {ConverterParameters{nan, 200}, ConverterParameters{0.0, 200},
        ConverterParameters{infinity, 200}, ConverterParameters{200e3, 0},
        ConverterParameters{-200e3, 200}}) {
    EXPECT_THROW(converter.blockDurationNanoseconds(), std::invalid_argument);
    EXPECT_THROW(converter.wholeBlocks(0.1, "period"), std::invalid_argument);
  }
}

}  // namespace
}  // namespace cvg
