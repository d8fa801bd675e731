#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <cstdio>
#include <stdexcept>

#include "logs/log_fixture.h"
#include "ring_gyro/common/angle.h"
#include "ring_gyro/common/number_text.h"
#include "ring_gyro/demodulation/orbit.h"
#include "ring_gyro/logs/log_table.h"
#include "ring_gyro/logs/quantity.h"

namespace cvg {
namespace {

using Complex = std::complex<double>;

constexpr double kFrequency = kTwoPi * 14195.0;
const char kHeader[] = "t,a,b,theta,phi,omega,beta,alpha\n";

struct Example {
  double t, a, b, theta, phi, beta, alpha;
};

Example example(int k) {
  return {1.0 + 1e-3 * k, 1.0 + 1e-4 * k, 1e-3, 0.01 * k, -1.55, 2e-6 + 1e-9 * k, 1e-3 * k};
}

std::string rowText(int k, const char* format = "%.9f,%.9f,%.9f,%.9f,%.9f,%.9f,%.12f,%.9f\n") {
  const Example e = example(k);
  char text[300];
  std::snprintf(text, sizeof text, format, e.t, e.a, e.b, e.theta, e.phi, kFrequency, e.beta,
                e.alpha);
  return text;
}

std::string tableText(int rows) {
  std::string text = kHeader;
  for (int k = 0; k < rows; ++k) text += rowText(k);
  return text;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size()) {
    text.replace(at, from.size(), to);
  }
  return text;
}

class LogImport : public LogTest {
 protected:
  static void expectExample(const ImportedLog& log, std::size_t rows) {
    ASSERT_EQ(log.blocks.size(), rows);
    for (std::size_t k = 0; k < rows; ++k) {
      const auto& [elements, gains] = log.blocks[k];
      const Example e = example(static_cast<int>(k));
      EXPECT_EQ(elements.stamp.sequence, k);
      EXPECT_EQ(elements.stamp.end_ns, 1000000000 + 1000000 * static_cast<std::int64_t>(k));
      EXPECT_EQ(elements.stamp.duration_ns, 1000000);
      EXPECT_NEAR(elements.orbit.a, e.a, 1e-9);
      EXPECT_NEAR(elements.orbit.b, e.b, 1e-9);
      EXPECT_NEAR(elements.orbit.theta, e.theta, 1e-8);
      EXPECT_NEAR(elements.orbit.phi, e.phi, 1e-8);
      EXPECT_NEAR(gains.reference_frequency, kFrequency, 1e-6);
      EXPECT_NEAR(gains.beta, e.beta, 1e-12);
      EXPECT_NEAR(gains.alpha, e.alpha, 1e-9);
      EXPECT_TRUE(elements.status.usable());
    }
  }
};

TEST_F(LogImport, SimplestForm) {
  write(tableText(20));
  const ImportedLog log = import();
  expectExample(log, 20);
  EXPECT_EQ(log.counts.rows, 20U);
  EXPECT_EQ(log.counts.faults.total(), 0U);
  EXPECT_TRUE(contains(log.table, "theta (guess)")) << log.table;
}

TEST_F(LogImport, DriveIsRebuiltFromTheMeasuredOrbit) {
  write(tableText(20));
  ImportOptions options;
  options.drive_lead = 0.0;
  const ImportedLog log = import({}, options);
  // (28): beta v + alpha J u, of the orbit at the begin of the interval.
  const Example before = example(9);
  const Example row = example(10);
  const Eigen::Vector2cd orbit = envelopeFromOrbit({before.a, before.b, before.theta, -0.5 * kPi});
  const Eigen::Vector2cd velocity = Complex(0.0, kFrequency) * orbit;
  const Eigen::Vector2cd expected =
      row.beta * velocity + row.alpha * Eigen::Vector2cd(orbit[1], -orbit[0]);
  EXPECT_LT((log.blocks[10].second.drive.total() - expected).norm(), 1e-8);
}

TEST_F(LogImport, WithoutHeaderInTheOrderOfTheSimplestForm) {
  write(replaced(tableText(20), kHeader, ""));
  expectExample(import(), 20);
}

TEST_F(LogImport, ByteOrderMarkAndCarriageReturns) {
  write("\xEF\xBB\xBF" + replaced(tableText(20), "\n", "\r\n"));
  expectExample(import(), 20);
}

TEST_F(LogImport, SemicolonsAndDecimalCommas) {
  write(replaced(replaced(tableText(20), ",", ";"), ".", ","));
  expectExample(import(), 20);
}

TEST_F(LogImport, DecimalCommasInQuotes) {
  std::string text = kHeader;
  for (int k = 0; k < 20; ++k) {
    text += replaced(
        rowText(k, "\"%.9f\",\"%.9f\",\"%.9f\",\"%.9f\",\"%.9f\",\"%.9f\",\"%.12f\",\"%.9f\"\n"),
        ".", ",");
  }
  write(text);
  expectExample(import(), 20);
}

TEST_F(LogImport, BlanksCommentsAndLinesBeforeTheTable) {
  write("recorded by the lab\n\n# of 2020\n" + replaced(tableText(20), ",", "   "));
  expectExample(import(), 20);
}

TEST_F(LogImport, HeaderInTheLastComment) {
  write("# numpy.savetxt\n# " + tableText(20));
  expectExample(import(), 20);
}

TEST_F(LogImport, LineOfUnits) {
  std::string text = "time,amp,quad,angle,phase,frequency,beta,alpha\nms,mV,mV,deg,deg,kHz,us,1\n";
  for (int k = 0; k < 20; ++k) {
    const Example e = example(k);
    char line[300];
    std::snprintf(line, sizeof line, "%.6f,%.6f,%.6f,%.9f,%.9f,%.9f,%.9f,%.9f\n", 1e3 * e.t,
                  1e3 * e.a, 1e3 * e.b, toDegrees(e.theta), toDegrees(e.phi), 14.195, 1e6 * e.beta,
                  e.alpha);
    text += line;
  }
  write(text);
  expectExample(import(), 20);
}

TEST_F(LogImport, ColumnsUnitsAndSignsThatAreSaid) {
  std::string text = "i;w1;w2;w3;w4;w5;w6;w7;w8\n";
  for (int k = 0; k < 20; ++k) {
    const Example e = example(k);
    char line[300];
    std::snprintf(line, sizeof line, "%d;%.9f;%.9f;%.9f;%.9f;%.9f;%.9f;%.12f;%.9f\n", k, e.t,
                  500.0 * e.a, -e.b, toDegrees(e.theta) / 2.0, e.phi + 0.5 * kPi, 14195.0, e.beta,
                  e.alpha);
    text += line;
  }
  write(text);
  ImportOptions options;
  options.phi_offset = -0.5 * kPi;
  expectExample(import({"t=w1", "a=w2:2mV", "b=-w3", "theta=5:2deg", "phi=w5", "omega=w6:Hz",
                        "beta=w7", "alpha=9"},
                       options),
                20);
}

TEST_F(LogImport, FoldedThetaIsUnwrapped) {
  std::string text = kHeader;
  for (int k = 0; k < 700; ++k) {
    Example e = example(k);
    e.theta = std::remainder(e.theta, kPi);
    char line[300];
    std::snprintf(line, sizeof line, "%.9f,1,0,%.12f,-1.57,%.9f,2e-6,0\n", e.t, e.theta,
                  kFrequency);
    text += line;
  }
  write(text);
  const ImportedLog log = import();
  EXPECT_NEAR(log.blocks.back().first.orbit.theta, example(699).theta, 1e-9);
  EXPECT_NEAR(log.counts.highest_theta - log.counts.lowest_theta, 6.99, 1e-9);
  EXPECT_NEAR(log.blocks.back().first.theta_rate, 10.0, 1e-3);
}

TEST_F(LogImport, OtherBranchOfPhi) {
  std::string text = kHeader;
  for (int k = 0; k < 20; ++k) {
    char line[300];
    std::snprintf(line, sizeof line, "%.9f,1,0,0.1,%.9f,%.9f,2e-6,0\n", example(k).t, 0.5 * kPi,
                  kFrequency);
    text += line;
  }
  write(text);
  const Orbit orbit = import().blocks.back().first.orbit;
  EXPECT_NEAR(orbit.phi, -0.5 * kPi, 1e-8);
  EXPECT_NEAR(std::remainder(orbit.theta - 0.1 - kPi, kTwoPi), 0.0, 1e-12);
}

TEST_F(LogImport, Envelopes) {
  std::string text = "t,Cx,Sx,Cy,Sy,omega,beta,alpha\n";
  for (int k = 0; k < 20; ++k) {
    const Example e = example(k);
    const Eigen::Vector2cd envelope = envelopeFromOrbit({e.a, e.b, e.theta, e.phi});
    char line[300];
    std::snprintf(line, sizeof line, "%.9f,%.12f,%.12f,%.12f,%.12f,%.9f,%.12f,%.9f\n", e.t,
                  envelope[0].real(), -envelope[0].imag(), envelope[1].real(), -envelope[1].imag(),
                  kFrequency, e.beta, e.alpha);
    text += line;
  }
  write(text);
  expectExample(import(), 20);
}

std::string samplesText(int rows, double shift) {
  std::string text = "t,x,y,f_Hz,sustain_V,quadrature_drive_V,psi\n";
  const Eigen::Vector2cd envelope = envelopeFromOrbit({1.0, 0.01, 0.4, -0.5 * kPi});
  for (int k = 0; k < rows; ++k) {
    const double t = k / 200e3;
    const double psi = std::fmod(kFrequency * t + 0.3, kTwoPi);
    const Complex turn = std::polar(1.0, kFrequency * t + 0.3);
    char line[300];
    std::snprintf(line, sizeof line, "%.6f,%.12f,%.12f,14195,0.5,0.02,%.12f\n", t,
                  (envelope[0] * turn).real(), (envelope[1] * turn).real(),
                  std::fmod(psi + shift, kTwoPi));
    text += line;
  }
  return text;
}

TEST_F(LogImport, SamplesAreDemodulated) {
  write(samplesText(4000, 0.0));
  const ImportedLog log = import();
  ASSERT_GT(log.blocks.size(), 15U);
  for (const auto& [elements, gains] : log.blocks) {
    EXPECT_EQ(elements.stamp.duration_ns, 1000000);
    EXPECT_NEAR(elements.orbit.a, 1.0, 1e-5);
    EXPECT_NEAR(elements.orbit.b, 0.01, 1e-5);
    EXPECT_NEAR(elements.orbit.theta, 0.4, 1e-5);
    EXPECT_NEAR(elements.orbit.phi, -0.5 * kPi, 1e-5);
    EXPECT_GT(elements.group_delay, 0.5e-3);
    EXPECT_NEAR(gains.beta * kFrequency * elements.orbit.a, 0.5, 1e-6);
    EXPECT_NEAR(gains.alpha * elements.orbit.a, 0.02, 1e-6);
  }
}

TEST_F(LogImport, SamplesWithoutReferencePhaseAreTakenAsLocked) {
  write(replaced(samplesText(4000, 0.0), "psi", "unknown"));
  const ImportedLog log = import();
  ASSERT_GT(log.blocks.size(), 15U);
  EXPECT_NEAR(std::remainder(log.blocks.back().first.orbit.theta - 0.4, kPi), 0.0, 1e-5);
  EXPECT_EQ(log.blocks.back().first.orbit.phi, -0.5 * kPi);
}

TEST_F(LogImport, FastRowsAreAveraged) {
  std::string text = "a,b,theta,phi,omega,beta,alpha\n";
  for (int k = 0; k < 100; ++k) {
    char line[300];
    std::snprintf(line, sizeof line, "%d,0,%.9f,-1.57,%.9f,2e-6,0\n", 1 + k / 10 * 0, 1e-3 * k,
                  kFrequency);
    text += line;
  }
  write(text);
  ImportOptions options;
  options.sample_rate = 10e3;
  const ImportedLog log = import({}, options);
  ASSERT_EQ(log.blocks.size(), 10U);
  EXPECT_EQ(log.blocks[3].first.stamp.duration_ns, 1000000);
  EXPECT_NEAR(log.blocks[3].first.group_delay, 0.45e-3, 1e-12);
  EXPECT_NEAR(log.blocks[3].first.orbit.theta, 34.5e-3, 1e-9);
}

TEST_F(LogImport, SteeringNeedsTheDriveGain) {
  std::string text = "t,a,b,theta,phi,omega,beta,alpha,virtual_rate\n";
  for (int k = 0; k < 20; ++k) text += replaced(rowText(k), "\n", ",0.2\n");
  write(text);
  EXPECT_TRUE(contains(faultOf(), "--drive-gain")) << faultOf();
  ImportOptions options;
  options.drive_gain = 1e5;
  const ControlGains gains = import({}, options).blocks[10].second;
  EXPECT_NEAR(gains.virtual_rate, 0.2, 1e-12);
  EXPECT_NEAR(gains.drive.steering.norm(), 2.0 * 0.2 / 1e5 * kFrequency * example(9).a, 1e-6);
}

TEST_F(LogImport, SteeringVolts) {
  std::string text = "t,a,b,theta,phi,omega,beta,alpha,steering_mV\n";
  for (int k = 0; k < 20; ++k) text += replaced(rowText(k), "\n", ",20\n");
  write(text);
  const ControlGains gains = import().blocks[10].second;
  EXPECT_NEAR(gains.drive.steering.norm(), 0.02 * example(9).a / example(9).a, 1e-6);
}

TEST_F(LogImport, MirroredLab) {
  write(tableText(20));
  ImportOptions options;
  options.mirror = true;
  const ImportedLog log = import({}, options);
  EXPECT_NEAR(log.blocks[10].first.orbit.theta, -example(10).theta, 1e-8);
  EXPECT_NEAR(log.blocks[10].first.orbit.b, -example(10).b, 1e-8);
  EXPECT_NEAR(log.blocks[10].second.alpha, -example(10).alpha, 1e-8);
}

TEST_F(LogImport, ExportedTableComesBackToTheSameBits) {
  OrbitalElements elements;
  ControlGains gains;
  std::string text = logHeader();
  for (std::uint64_t k = 0; k < 50; ++k) {
    const double x = std::sin(1.0 + static_cast<double>(k));
    elements.stamp =
        gains.stamp = {1, 1000 + k, 2000000123 + 1000000 * static_cast<std::int64_t>(k), 1000000};
    elements.group_delay = 0.00063;
    elements.orbit = {1.0 + 1e-3 * x, 1e-5 * x, -200.0 + 0.01 * x, -1.57 + 1e-4 * x};
    gains.reference_frequency = kFrequency + x;
    gains.beta = 2e-6 + 1e-8 * x;
    gains.alpha = 1e-4 * x;
    gains.virtual_rate = 0.2;
    gains.drive.sustain = {Complex(x, 0.1 * x), Complex(0.3 * x, 1e-9 * x)};
    gains.drive.steering = {Complex(0.7, x / 3.0), Complex(x * x, x)};
    LoopStatus& status = elements.status;
    status.amplitude_locked = status.quadrature_locked = status.phase_locked = k != 7;
    gains.status = status;
    appendLogRow(elements, gains, text);
  }
  write(text);
  std::string again = logHeader();
  const ImportedLog log = import();
  for (const auto& [e, g] : log.blocks) appendLogRow(e, g, again);
  EXPECT_EQ(again, text);
  EXPECT_EQ(log.counts.unusable_blocks, 1U);
}

TEST_F(LogImport, MissingRowsBecomeMissingSequences) {
  std::string text = kHeader;
  for (int k = 0; k < 20; ++k) text += k == 7 || k == 8 ? "" : rowText(k);
  write(text);
  const ImportedLog log = import();
  EXPECT_EQ(log.counts.missing_rows, 2U);
  EXPECT_EQ(log.blocks[7].first.stamp.sequence, 9U);
  EXPECT_EQ(log.blocks[7].first.stamp.end_ns, 1009000000);
}

TEST_F(LogImport, SaysWhereTheGroupDelayIsFrom) {
  write(tableText(20));
  ImportOptions options;
  options.group_delay = 1e-3;
  EXPECT_EQ(import({}, options).group_delay, "0.001 s");
  EXPECT_EQ(import({}, {}, {"group_delay=2ms"}).group_delay, "0.002 s");
  std::string text = replaced(tableText(20), "alpha\n", "alpha,Delay [ms]\n");
  write(replaced(text, "0\n", "0,1.5\n"));
  const ImportedLog log = import({"group_delay=Delay"});
  EXPECT_EQ(log.group_delay, "from column Delay [ms]");
  EXPECT_NEAR(log.blocks[3].first.group_delay, 1.5e-3, 1e-12);
}

// The drive is pointed by the motion as it was when it acted, wherever the delay is told.
TEST_F(LogImport, GroupDelayOfAColumnPointsTheDriveToo) {
  write(tableText(20));
  ImportOptions options;
  options.group_delay = 1.5e-3;
  const ImportedLog by_option = import({}, options);
  std::string text = replaced(tableText(20), "alpha\n", "alpha,Delay [ms]\n");
  write(replaced(text, "0\n", "0,1.5\n"));
  const ImportedLog by_column = import({"group_delay=Delay"});
  ASSERT_EQ(by_column.blocks.size(), by_option.blocks.size());
  for (std::size_t k = 0; k < by_option.blocks.size(); ++k) {
    const Eigen::Vector2cd told = by_option.blocks[k].second.drive.total();
    EXPECT_LT((by_column.blocks[k].second.drive.total() - told).norm(), 1e-12 * told.norm()) << k;
  }
}

// Bad input: one line with file, place, fault and mend; with --partial the rest is taken.

class BadLog : public LogImport {
 protected:
  /// Row 12 of 20 (line 14) is replaced.
  void writeWith(const std::string& row) const {
    std::string text = kHeader;
    for (int k = 0; k < 20; ++k) text += k == 12 ? row : rowText(k);
    write(text);
  }
  void expectRowFault(const std::string& part, RowFault kind) const {
    const std::string fault = faultOf();
    EXPECT_TRUE(contains(fault, "log.csv, line 14")) << fault;
    EXPECT_TRUE(contains(fault, part)) << fault;
    EXPECT_TRUE(contains(fault, "--partial")) << fault;
    EXPECT_EQ(std::count(fault.begin(), fault.end(), '\n'), 0);
    ImportOptions options;
    options.partial = true;
    const ImportedLog log = import({}, options);
    EXPECT_EQ(log.blocks.size(), 19U);
    EXPECT_EQ(log.counts.faults.counts[static_cast<std::size_t>(kind)], 1U);
    EXPECT_EQ(log.counts.faults.total(), 1U);
    EXPECT_EQ(log.counts.faults.first, fault);
    EXPECT_EQ(log.blocks[12].first.stamp.sequence, 13U);
  }
};

TEST_F(BadLog, RaggedRow) {
  writeWith("1.012,1,0,0.12,-1.57\n");
  expectRowFault("5 fields where there are 8 columns", RowFault::kRagged);
}

TEST_F(BadLog, CommasAreDelimiterAndDecimalSign) {
  write(kHeader + replaced(replaced(tableText(20), kHeader, ""), ".", ","));
  const std::string fault = faultOf();
  EXPECT_TRUE(contains(fault, "log.csv, line 1: 8 names over rows of 16 fields")) << fault;
  EXPECT_TRUE(contains(fault, "commas are both delimiter and decimal sign")) << fault;
  EXPECT_TRUE(contains(fault, "write the file with ';' between the fields")) << fault;
}

TEST_F(BadLog, RowsWithFewerCommasBecauseOfWholeNumbers) {
  write(replaced(replaced(tableText(20), kHeader, ""), ".", ",") +
        "1,02,1,0,0,12,-1,57,89190,0,0\n");
  const std::string fault =
      faultOf({"t=1", "a=2", "b=3", "theta=4", "omega=5", "beta=6", "alpha=7"});
  EXPECT_TRUE(contains(fault, "line 21: 11 fields where there are 16 columns")) << fault;
  EXPECT_TRUE(contains(fault, "if commas are both delimiter and decimal sign, write")) << fault;
}

TEST_F(BadLog, CutInTheMiddleOfALine) {
  std::string text = tableText(20);
  text.resize(text.size() - 30);
  write(text);
  EXPECT_TRUE(contains(faultOf(), "the file ends in the middle of it")) << faultOf();
  ImportOptions options;
  options.partial = true;
  EXPECT_EQ(import({}, options).blocks.size(), 19U);
}

TEST_F(BadLog, NotANumber) {
  writeWith("1.012,1,0,oops,-1.57,89190,2e-6,0\n");
  expectRowFault("column theta: 'oops' is no number", RowFault::kNotANumber);
}

TEST_F(BadLog, EmptyField) {
  writeWith("1.012,1,,0.12,-1.57,89190,2e-6,0\n");
  expectRowFault("column b: is empty", RowFault::kNotANumber);
}

TEST_F(BadLog, NaN) {
  writeWith("1.012,1,0,NaN,-1.57,89190,2e-6,0\n");
  expectRowFault("column theta: is nan", RowFault::kNotFinite);
}

TEST_F(BadLog, TimeThatDoesNotGrow) {
  writeWith(rowText(11));
  expectRowFault("does not grow", RowFault::kTime);
}

TEST_F(BadLog, DecimalCommasBetweenCommas) {
  std::string text = kHeader;
  for (int k = 0; k < 20; ++k) text += replaced(rowText(k), ".", ",");
  write(text);
  const std::string fault = faultOf();
  EXPECT_TRUE(contains(fault, "log.csv")) << fault;
  EXPECT_FALSE(fault.empty());
}

TEST_F(BadLog, MissingColumn) {
  write(replaced(tableText(20), "theta", "something"));
  const std::string fault = faultOf();
  EXPECT_TRUE(contains(fault, "no column for theta (pattern angle)")) << fault;
  EXPECT_TRUE(contains(fault, "something")) << fault;
}

TEST_F(BadLog, UnknownColumnInTheMap) {
  write(tableText(20));
  const std::string fault = faultOf({"theta=Winkel:deg"});
  EXPECT_TRUE(contains(fault, "has no column Winkel")) << fault;
}

TEST_F(BadLog, UnknownQuantityInTheMap) {
  write(tableText(20));
  EXPECT_THROW(import({"thta=theta"}), std::invalid_argument);
}

TEST_F(BadLog, UnitOfAnotherDimension) {
  write(tableText(20));
  const std::string fault = faultOf({"theta=theta:mV"});
  EXPECT_TRUE(contains(fault, "mV is no unit of theta")) << fault;
}

TEST_F(BadLog, HeaderWithAUnitOfAnotherDimension) {
  write(replaced(tableText(20), "theta", "theta [mV]"));
  const std::string fault = faultOf();
  EXPECT_TRUE(contains(fault, "[column theta [mV] has another unit]")) << fault;
}

TEST_F(BadLog, PhiInDegreesSaidToBeRadians) {
  write(replaced(tableText(20), "-1.550000000", "-90.0"));
  const std::string fault = faultOf();
  EXPECT_TRUE(contains(fault, "--column phi=COLUMN:deg")) << fault;
}

TEST_F(BadLog, PhiOfAnotherReference) {
  write(replaced(tableText(20), "-1.550000000", "0.001"));
  const std::string fault = faultOf();
  EXPECT_TRUE(contains(fault, "--phi-offset -90deg")) << fault;
}

TEST_F(BadLog, AmplitudeInMillivoltsSaidToBeVolts) {
  std::string text = kHeader;
  for (int k = 0; k < 20; ++k) text += replaced(rowText(k), ",1.00", ",1000.00");
  write(text);
  EXPECT_TRUE(contains(faultOf(), "a = 1000")) << faultOf();
}

TEST_F(BadLog, ThetaInDegreesSaidToBeRadians) {
  std::string text = kHeader;
  for (int k = 0; k < 40; ++k) {
    char line[300];
    std::snprintf(line, sizeof line, "%.6f,1,0,%.6f,-1.57,%.6f,2e-6,0\n", 1.0 + 1e-3 * k,
                  std::remainder(170.0 + k, 360.0), kFrequency);
    text += line;
  }
  write(text);
  EXPECT_TRUE(contains(faultOf(), "--column theta=COLUMN:deg")) << faultOf();
}

TEST_F(BadLog, EmptyFile) {
  write("");
  EXPECT_TRUE(contains(faultOf(), "is empty")) << faultOf();
}

TEST_F(BadLog, HeaderAlone) {
  write(kHeader);
  EXPECT_TRUE(contains(faultOf(), "no rows of numbers")) << faultOf();
}

TEST_F(BadLog, NoSuchFile) {
  EXPECT_TRUE(contains(faultOf(), "cannot be read: No such file")) << faultOf();
}

TEST_F(BadLog, Utf16) {
  write(std::string("\xFF\xFEt\0,\0", 6));
  EXPECT_TRUE(contains(faultOf(), "UTF-16")) << faultOf();
}

TEST_F(BadLog, LineWithoutEnd) {
  write(tableText(20) + std::string(3 << 20, '1'));
  EXPECT_TRUE(contains(faultOf(), "longer than 1 MiB")) << faultOf();
}

TEST(Quantities, EachHasARangeWithTwoEnds) {
  for (const QuantityInfo& info : quantities()) {
    EXPECT_TRUE(std::isfinite(info.range.lowest) && std::isfinite(info.range.highest)) << info.name;
    EXPECT_FALSE(info.range.contains(1e300)) << info.name;
    EXPECT_FALSE(info.range.contains(-1e300)) << info.name;
  }
}

/// What stands in a good log in row k.
double usualValue(const std::string& name, int k) {
  if (name == "t") return 1.0 + 1e-3 * k;
  if (name == "a" || name == "sx" || name == "usable") return 1.0;
  if (name == "theta") return 0.01 * k;
  if (name == "phi") return -1.55;
  if (name == "omega") return kFrequency;
  if (name == "beta") return 2e-6;
  if (name == "sequence") return k;
  return 0.0;
}

/// A table with these columns, in which one value is another.
std::string tableOf(const std::vector<std::string>& names, int rows, const std::string& changed,
                    int changed_row, double value) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ",") + name;
  for (int k = 0; k < rows; ++k) {
    for (const std::string& name : names) {
      text += name == names.front() ? '\n' : ',';
      appendNumber(text, name == changed && k == changed_row ? value : usualValue(name, k));
    }
  }
  return text + "\n";
}

/// Beyond the first rows too, by which period and conventions are seen.
TEST_F(BadLog, AbsurdValueOfEachQuantity) {
  const std::vector<std::vector<std::string>> forms = {
      {"t",
       "a",
       "b",
       "theta",
       "phi",
       "omega",
       "beta",
       "alpha",
       "virtual_rate",
       "compensation_gain1",
       "compensation_gain2",
       "sustain_volts",
       "quadrature_volts",
       "steering_volts",
       "drive_x_real",
       "drive_x_imag",
       "drive_y_real",
       "drive_y_imag",
       "psi",
       "group_delay",
       "usable",
       "sequence"},
      {"t", "cx", "sx", "cy", "sy", "omega", "beta", "alpha"},
      {"t", "x", "y", "omega", "beta", "alpha"}};
  std::size_t tried = 0;
  for (const std::vector<std::string>& names : forms) {
    for (const std::string& name : names) {
      if (&names != &forms.front() && name.size() > 2) continue;  // has been tried
      const QuantityInfo& info = infoOf(*quantityFromName(name));
      ++tried;
      for (const auto& [row, value] :
           std::vector<std::pair<int, double>>{{12, 1e300},
                                               {12, -1e305},
                                               {12, std::nextafter(info.range.highest, 1e300)},
                                               {2300, 1e300}}) {
        const bool samples = &names == &forms.back();  // which rows as slow as these cannot be
        if (samples && row > 2000) continue;
        const int rows = row + 8;
        write(tableOf(names, rows, name, row, value));
        const std::string fault = faultOf();
        EXPECT_TRUE(contains(fault, "log.csv, line " + std::to_string(row + 2) + ", column " +
                                        name + ": " + name + " = "))
            << fault;
        EXPECT_TRUE(contains(fault, "is out of range; allowed: " + info.range.text())) << fault;
        EXPECT_TRUE(contains(fault, "--partial")) << fault;
        EXPECT_EQ(std::count(fault.begin(), fault.end(), '\n'), 0);
        if (samples) continue;
        ImportOptions options;
        options.partial = true;
        const ImportedLog log = import({}, options);
        EXPECT_EQ(log.counts.faults.counts[static_cast<std::size_t>(RowFault::kOutOfRange)], 1U);
        EXPECT_EQ(log.counts.faults.total(), 1U) << log.counts.faults.first;
      }
    }
  }
  EXPECT_EQ(tried, 22U + 5U + 3U);
}

/// Whatever is allowed makes blocks that the readers of a bag take, or is refused for what it
/// makes.
TEST_F(BadLog, EndsOfTheRangesMakeBlocksThatAreRead) {
  const std::vector<std::string> names = {"t",
                                          "a",
                                          "b",
                                          "theta",
                                          "phi",
                                          "omega",
                                          "beta",
                                          "alpha",
                                          "virtual_rate",
                                          "compensation_gain1",
                                          "compensation_gain2"};
  constexpr double kReadable = 1e12;
  const auto text = [&names](const std::string& changed, bool highest) {
    std::string rows = tableOf(names, 1, "", 0, 0.0);
    for (int k = 1; k < 20; ++k) {
      for (const std::string& name : names) {
        const Range& range = infoOf(*quantityFromName(name)).range;
        rows += name == "t" ? "" : ",";
        const bool other = name == changed || (changed.empty() && name != "t" && name != "theta" &&
                                               name != "phi" && name != "omega");
        appendNumber(rows, !other ? usualValue(name, k) : highest ? range.highest : range.lowest);
      }
      rows += '\n';
    }
    return rows;
  };
  std::size_t all_taken = 0;
  for (const std::string changed :
       {"", "a", "b", "beta", "alpha", "virtual_rate", "compensation_gain1"}) {
    for (const bool highest : {false, true}) {
      write(text(changed, highest));
      ImportOptions options;
      options.drive_gain = 1e9;
      options.partial = true;
      ImportedLog log;
      try {
        log = import({}, options);
      } catch (const LogError& error) {
        EXPECT_TRUE(contains(error.what(), "too few") || contains(error.what(), "no block"))
            << error.what();
      }
      const auto& faults = log.counts.faults;
      EXPECT_EQ(faults.counts[static_cast<std::size_t>(RowFault::kOutOfRange)], faults.total())
          << faults.first;
      all_taken += faults.total() == 0 ? 1 : 0;
      if (changed.empty()) {
        EXPECT_TRUE(contains(faults.first, "line 3: its gains make a drive of ")) << faults.first;
      }
      for (const auto& [elements, gains] : log.blocks) {
        const Orbit& orbit = elements.orbit;
        EXPECT_LT(std::abs(orbit.a) + std::abs(orbit.b) + std::abs(orbit.theta) +
                      std::abs(elements.theta_rate),
                  kReadable);
        EXPECT_LT(gains.drive.sustain.cwiseAbs().sum() + gains.drive.quadrature.cwiseAbs().sum() +
                      gains.drive.steering.cwiseAbs().sum() +
                      gains.drive.compensation.cwiseAbs().sum(),
                  kReadable);
      }
    }
  }
  EXPECT_GE(all_taken, 4U);
}

TEST_F(BadLog, ConstantsAndOptionsThatCannotBe) {
  write(replaced(tableText(20), "alpha", "other"));
  for (const std::string constant : {"alpha=1e300", "alpha=-1e8"}) {
    try {
      import({}, {}, {constant});
      FAIL() << constant;
    } catch (const LogError& error) {
      EXPECT_TRUE(contains(error.what(), "--constant alpha: alpha = ")) << error.what();
      EXPECT_TRUE(contains(error.what(), "allowed: [-1e+07, 1e+07]")) << error.what();
    }
  }
  EXPECT_THROW(import({}, {}, {"alpha=1e400"}), std::invalid_argument);
  write(tableText(20));
  const auto expectRefused = [this](const char* name, const auto& set) {
    ImportOptions options;
    set(options);
    try {
      import({}, options);
      FAIL() << name;
    } catch (const std::exception& error) {
      EXPECT_TRUE(contains(error.what(), name)) << error.what();
    }
  };
  expectRefused("--group-delay", [](ImportOptions& o) { o.group_delay = 1e300; });
  expectRefused("--phi-offset", [](ImportOptions& o) { o.phi_offset = 1e300; });
  expectRefused("--drive-lead", [](ImportOptions& o) { o.drive_lead = -1e300; });
  expectRefused("--drive-gain", [](ImportOptions& o) { o.drive_gain = 1e300; });
  expectRefused("--minimum-amplitude", [](ImportOptions& o) { o.minimum_amplitude = 1e300; });
  expectRefused("--attenuation", [](ImportOptions& o) { o.stopband_attenuation = NAN; });
  expectRefused("--average", [](ImportOptions& o) { o.average = std::int64_t{1} << 62; });
}

/// Each value is allowed, but together no stamp can say them.
TEST_F(BadLog, BlocksBehindTheEndOfTime) {
  std::string text = "t,a,b,theta,phi,omega,beta,alpha,sequence\n";
  for (int k = 0; k < 20; ++k) {
    std::string row = rowText(k);
    row.pop_back();
    text += row + "," + (k == 15 ? "8e15" : std::to_string(k)) + "\n";
  }
  write(text);
  EXPECT_TRUE(contains(faultOf(), "log.csv, line 17: lies 8e+15 blocks behind the first"))
      << faultOf();

  text = kHeader;
  for (int k = 0; k < 20; ++k) {
    const std::string row = rowText(k);
    text += (k == 0    ? "-4e9"
             : k == 15 ? "4e9"
                       : std::to_string(-4e9 + k)) +
            row.substr(row.find(','));
  }
  write(text);
  EXPECT_TRUE(contains(faultOf(), "line 17: lies ")) << faultOf();
}

TEST_F(BadLog, MoreColumnsThanSignals) {
  std::string header = "t";
  std::string row = "1";
  for (int k = 0; k < 120000; ++k) {
    header += ",c";
    row += ",1";
  }
  write(header + "\n" + row + "\n" + row + "\n" + row + "\n");
  EXPECT_TRUE(contains(faultOf(), "has 120001 fields, allowed are up to 100000")) << faultOf();
}

}  // namespace
}  // namespace cvg
