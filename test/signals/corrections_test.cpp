#include "ring_gyro/signals/corrections.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <complex>

namespace cvg {
namespace {

using Complex = std::complex<double>;

DrivePath somePath() {
  DrivePath path;
  path.phase = 0.3;
  path.mismatch = 0.01;
  path.skew = -0.02;
  path.rotation = 0.03;
  path.phase_mismatch = 0.004;
  path.phase_skew = -0.005;
  path.rotation_phase = 0.006;
  return path;
}

TEST(DrivePath, IsFoundAgainInAMultipleOfItsMatrix) {
  const DrivePath path = somePath();
  const DrivePath found = DrivePath::of(7.0 * path.matrix());
  EXPECT_NEAR(found.phase, path.phase, 1e-15);
  EXPECT_NEAR(found.mismatch, path.mismatch, 1e-15);
  EXPECT_NEAR(found.skew, path.skew, 1e-15);
  EXPECT_NEAR(found.rotation, path.rotation, 1e-15);
  EXPECT_NEAR(found.phase_mismatch, path.phase_mismatch, 1e-15);
  EXPECT_NEAR(found.phase_skew, path.phase_skew, 1e-15);
  EXPECT_NEAR(found.rotation_phase, path.rotation_phase, 1e-15);
}

TEST(Corrections, TurnsTheDriveByTheInverseOfItsPath) {
  Corrections corrections;
  corrections.drive_path = somePath();
  const Eigen::Matrix2cd whole = corrections.drive_path.matrix() * corrections.driveCorrection();
  EXPECT_LT((whole - Eigen::Matrix2cd::Identity()).norm(), 1e-14);
}

TEST(Corrections, LeavesWhatIsSwitchedOff) {
  Corrections corrections;
  corrections.drive_path = somePath();
  corrections.correct_phase = false;
  corrections.correct_phase_mismatch = false;
  const DrivePath corrected = DrivePath::of(corrections.driveCorrection().inverse());
  EXPECT_NEAR(corrected.phase, 0.0, 1e-15);
  EXPECT_NEAR(corrected.mismatch, 0.01, 1e-15);
  EXPECT_NEAR(corrected.phase_mismatch, 0.0, 1e-15);
  corrections.correct_drive_gains = false;
  EXPECT_LT((corrections.driveCorrection() - Eigen::Matrix2cd::Identity()).norm(), 1e-15);

  corrections.pickoff_cubic = 0.02;
  corrections.drift = {0.1, {}, {}};
  corrections.angle_map = {0.0, {}, {0.01}};
  corrections.correct_pickoff = corrections.cancel_drift = corrections.map_angle = false;
  const Eigen::Vector2cd envelope(Complex(1.0, 0.2), Complex(0.3, -0.4));
  EXPECT_EQ(corrections.undistorted(envelope), envelope);
  EXPECT_EQ(corrections.driftAt(0.7), 0.0);
  EXPECT_EQ(corrections.outputAngle(0.7), 0.7);
  EXPECT_EQ(corrections.outputSlope(0.7), 1.0);
}

// The fundamental of x + c x^3, x = |X| cos, by the mean over a cycle.
TEST(Corrections, UndoesTheFundamentalOfACubicPickoff) {
  Corrections corrections;
  for (const double cubic : {0.02, -0.05, 0.2}) {
    corrections.pickoff_cubic = cubic;
    const Eigen::Vector2cd envelope(std::polar(0.9, 0.4), std::polar(0.5, -2.0));
    Eigen::Vector2cd measured = Eigen::Vector2cd::Zero();
    constexpr int kSteps = 64;
    for (int i = 0; i < kSteps; ++i) {
      const Complex turn = std::polar(1.0, 2.0 * 3.14159265358979323846 * i / kSteps);
      for (int axis = 0; axis < 2; ++axis) {
        const double x = (envelope[axis] * turn).real();
        measured[axis] += 2.0 / kSteps * (x + cubic * x * x * x) * std::conj(turn);
      }
    }
    EXPECT_LT((corrections.undistorted(measured) - envelope).norm(), 1e-9) << cubic;
  }
}

}  // namespace
}  // namespace cvg
