#include "ring_gyro/common/number_text.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <string>

#include "ring_gyro/common/formatted.h"

namespace cvg {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(NumberText, TakesWhatIsWhollyANumber) {
  EXPECT_EQ(parseNumber("0.2"), 0.2);
  EXPECT_EQ(parseNumber(" +.2\t"), 0.2);
  EXPECT_EQ(parseNumber("-2e-1"), -0.2);
  EXPECT_EQ(parseNumber("2.E1"), 20.0);
  EXPECT_EQ(parseNumber("3,5", ','), 3.5);
  EXPECT_EQ(parseNumber("Infinity"), kInfinity);
  EXPECT_EQ(parseNumber("-inf"), -kInfinity);
  EXPECT_TRUE(std::isnan(parseNumber("NaN").value()));
  for (const char* text : {"", " ", "+", "-", ".", "e5", "1e", "1e+", "0x10", "nan(1)", "1 2",
                           "1.2.3", "+-2", "--2", "++2", "1,5", "12V", "infinit"}) {
    EXPECT_FALSE(parseNumber(text)) << text;
  }
  EXPECT_FALSE(parseNumber("3.5", ','));
}

TEST(NumberText, BeyondTheRangeOfDoublesIsInfiniteOrNothing) {
  EXPECT_EQ(parseNumber("1e400"), kInfinity);
  EXPECT_EQ(parseNumber("-1e400"), -kInfinity);
  EXPECT_EQ(parseNumber("1e-400"), 0.0);
  EXPECT_EQ(parseNumber("-1e-400"), 0.0);
  EXPECT_EQ(parseNumber("4.9406564584124654e-324"), std::numeric_limits<double>::denorm_min());
}

TEST(NumberText, EveryNumberIsReadBackFromItsText) {
  std::mt19937_64 random(11);
  for (int k = 0; k < 100000; ++k) {
    const std::uint64_t bits = random();
    double value = 0.0;
    std::memcpy(&value, &bits, sizeof value);
    if (std::isnan(value)) continue;
    const std::string text = textFromNumber(value);
    ASSERT_EQ(parseNumber(text), value) << text;
    ASSERT_LE(text.size(), 24u) << text;
  }
  EXPECT_EQ(textFromNumber(0.1), "0.1");
  EXPECT_EQ(textFromNumber(14000.0), "14000");
}

TEST(Formatted, IsNeverCut) {
  const std::string longest(100000, 'x');
  EXPECT_EQ(formatted("%s|%d", longest.c_str(), 7), longest + "|7");
  EXPECT_EQ(formatted("%s", ""), "");
}

}  // namespace
}  // namespace cvg
