#include "ring_gyro/common/parameter_table.h"

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

namespace cvg {
namespace {

struct Example {
  double rate = 1.0;
  std::int64_t count = 2;

  std::string fault() {
    ParameterTable table;
    table.number("rate", rate, "Hz", Range::above(0.0), "of something")
        .integer("count", count, Range::between(1, 9), "of something");
    try {
      requireInRange(table, "example/");
      return "";
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
  }
};

TEST(ParameterTable, SaysNothingOfNumbersInTheirRange) { EXPECT_EQ(Example().fault(), ""); }

TEST(ParameterTable, NamesEachNumberOutOfItsRange) {
  Example example;
  example.rate = -2e-9;
  example.count = 10;
  EXPECT_EQ(example.fault(),
            "example/rate = -2e-09: out of range; allowed: > 0 [Hz]\n"
            "example/count = 10: out of range; allowed: [1, 9], whole");
}

TEST(ParameterTable, NotANumberIsOutOfEveryRange) {
  Example example;
  example.rate = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(example.fault(), "example/rate = nan: out of range; allowed: > 0 [Hz]");
}

}  // namespace
}  // namespace cvg
