#include "ring_gyro/logs/column_map.h"

#include <gtest/gtest.h>

#include <cmath>

#include "ring_gyro/common/angle.h"
#include "ring_gyro/common/number_text.h"

namespace cvg {
namespace {

using Q = Quantity;
using Header = std::pair<std::string, std::string>;

TEST(SplitHeader, FindsUnitsHoweverTheyAreWritten) {
  EXPECT_EQ(splitHeader("Angle [deg]"), Header("Angle", "deg"));
  EXPECT_EQ(splitHeader("U / mV"), Header("U", "mV"));
  EXPECT_EQ(splitHeader("theta_deg"), Header("theta", "deg"));
  EXPECT_EQ(splitHeader("omega_rad_s"), Header("omega", "rad/s"));
  EXPECT_EQ(splitHeader("Rate (deg/s)"), Header("Rate", "deg/s"));
  EXPECT_EQ(splitHeader("virtual_rate"), Header("virtual_rate", ""));
  EXPECT_EQ(splitHeader("data(:,3)"), Header("data(:,3)", ""));
}

TEST(UnitScale, KnowsFactorsPrefixesAndCases) {
  EXPECT_EQ(unitScale("mV", Dimension::kVoltage), 1e-3);
  EXPECT_EQ(unitScale("2deg", Dimension::kAngle), 2.0 * toRadians(1.0));
  EXPECT_EQ(unitScale("2.5e-5", Dimension::kVoltage), 2.5e-5);
  EXPECT_EQ(unitScale("MHz", Dimension::kAngularRate), kTwoPi * 1e6);
  EXPECT_EQ(unitScale("mHz", Dimension::kAngularRate), kTwoPi * 1e-3);
  EXPECT_EQ(unitScale("HZ", Dimension::kAngularRate), kTwoPi);
  EXPECT_FALSE(unitScale("mV", Dimension::kAngle));
  EXPECT_FALSE(unitScale("furlong", Dimension::kVoltage));
}

TEST(ParseNumber, TakesNumbersAndNothingElse) {
  EXPECT_EQ(parseNumber(" 1.5e-3 "), 1.5e-3);
  EXPECT_EQ(parseNumber("+2"), 2.0);
  EXPECT_EQ(parseNumber("-1,25", ','), -1.25);
  EXPECT_EQ(parseNumber(".5"), 0.5);
  EXPECT_TRUE(std::isnan(parseNumber("NaN").value()));
  EXPECT_TRUE(std::isinf(parseNumber("-inf").value()));
  for (const char* text : {"", " ", "1.5x", "0x10", "1,5", "--1", "1 2", "e5", "12:30"}) {
    EXPECT_FALSE(parseNumber(text)) << text;
  }
  EXPECT_FALSE(parseNumber("1.5", ','));
}

TEST(ParseNumber, ReadsBackWhatWasAppended) {
  for (const double value : {0.1, -1.0 / 3.0, 6.02e23, 5e-324, 1e308}) {
    std::string text;
    appendNumber(text, value);
    EXPECT_EQ(parseNumber(text), value) << text;
  }
}

TEST(ColumnMap, GuessesTheNamesOfLabs) {
  const ColumnMap map("log",
                      {"Time [ms]", "Amplitude (mV)", "Quad / mV", "Angle_deg", "Phase [deg]",
                       "PLL frequency [Hz]", "Sustain gain [us]", "Quad gain", "Comment"},
                      {});
  for (const Q quantity :
       {Q::kTime, Q::kA, Q::kB, Q::kTheta, Q::kPhi, Q::kOmega, Q::kBeta, Q::kAlpha}) {
    ASSERT_TRUE(map.has(quantity)) << infoOf(quantity).name;
    EXPECT_EQ(map.use(quantity)->column, indexOf(quantity));
  }
  EXPECT_EQ(map.use(Q::kA)->scale, 1e-3);
  EXPECT_EQ(map.use(Q::kOmega)->scale, kTwoPi);
  EXPECT_EQ(map.use(Q::kTheta)->scale, toRadians(1.0));
  map.requireComplete(false);
}

TEST(ColumnMap, FrequenciesAreHertzUnlessTheirNameIsOmega) {
  EXPECT_EQ(ColumnMap("log", {"freq"}, {}).use(Q::kOmega)->scale, kTwoPi);
  EXPECT_EQ(ColumnMap("log", {"omega"}, {}).use(Q::kOmega)->scale, 1.0);
}

TEST(ColumnMap, KnowsTheNamesThatOlderVersionsExported) {
  const ColumnMap map("log", {"compensation_gain_1", "compensation_gain_2"}, {});
  EXPECT_EQ(map.use(Q::kCompensationGain1)->column, 0U);
  EXPECT_EQ(map.use(Q::kCompensationGain2)->column, 1U);
  EXPECT_EQ(map.use(Q::kCompensationGain2)->scale, 1.0);
}

TEST(ColumnMap, VoltsAreNotGains) {
  const ColumnMap map("log", {"sustain [V]", "steering_mV"}, {});
  EXPECT_TRUE(map.has(Q::kSustainVolts));
  EXPECT_TRUE(map.has(Q::kSteeringVolts));
  EXPECT_FALSE(map.has(Q::kBeta));
}

TEST(ColumnMap, WhatIsSaidComesBeforeWhatIsGuessed) {
  const ColumnMap map("log", {"theta", "angle"}, {"theta=-angle:deg"});
  EXPECT_EQ(map.use(Q::kTheta)->column, 1U);
  EXPECT_EQ(map.use(Q::kTheta)->scale, -toRadians(1.0));
}

TEST(ColumnMap, UnitOfTheHeaderHoldsForAColumnThatIsSaid) {
  const ColumnMap map("log", {"Winkel [deg]"}, {"theta=Winkel"});
  EXPECT_EQ(map.use(Q::kTheta)->scale, toRadians(1.0));
}

TEST(ColumnMap, ConstantsAndIgnoredColumns) {
  const ColumnMap map("log", {"t", "f"}, {}, {"omega=14.195kHz"}, {"t"});
  EXPECT_FALSE(map.use(Q::kOmega)->column);
  EXPECT_NEAR(map.use(Q::kOmega)->constant, kTwoPi * 14195.0, 1e-9);
  EXPECT_FALSE(map.has(Q::kTime));
}

TEST(ColumnMap, ChoosesTheFormOfTheMotion) {
  EXPECT_EQ(ColumnMap("log", {"a", "b", "theta", "x", "y"}, {}).motion(),
            ColumnMap::Motion::kElements);
  EXPECT_EQ(ColumnMap("log", {"Cx", "Sx", "Cy", "Sy"}, {}).motion(), ColumnMap::Motion::kEnvelope);
  EXPECT_EQ(ColumnMap("log", {"a", "b", "theta", "p", "q"}, {"x=p", "y=q"}).motion(),
            ColumnMap::Motion::kSamples);
}

}  // namespace
}  // namespace cvg
