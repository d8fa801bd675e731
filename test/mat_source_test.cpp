#include <matio.h>

#include <cmath>

#include "log_fixture.h"
#include "ring_gyro/common/angle.h"

namespace ring_gyro {
namespace {

class MatLog : public LogTest {
 protected:
  using Vector = std::vector<double>;

  void open(mat_ft version) {
    file_ = Mat_CreateVer(path("log.mat").c_str(), nullptr, version);
    ASSERT_TRUE(file_);
  }
  void add(const char* name, Vector values, std::size_t columns = 1,
           matio_compression compression = MAT_COMPRESSION_NONE) {
    std::size_t dims[2] = {values.size() / columns, columns};
    matvar_t* const variable =
        Mat_VarCreate(name, MAT_C_DOUBLE, MAT_T_DOUBLE, 2, dims, values.data(), 0);
    ASSERT_EQ(Mat_VarWrite(file_, variable, compression), 0);
    Mat_VarFree(variable);
  }
  void close() { Mat_Close(file_); }

  static Vector line(double begin, double step) {
    Vector values;
    for (int k = 0; k < kRows; ++k) values.push_back(begin + step * k);
    return values;
  }
  /// Everything but theta and omega.
  void addRest(matio_compression compression) {
    add("t", line(1.0, 2e-3), 1, compression);
    add("a", line(1.0, 1e-4), 1, compression);
    add("b", line(0.0, 0.0), 1, compression);
    add("phi", line(-1.57, 0.0), 1, compression);
    add("beta", line(2e-6, 0.0), 1, compression);
    add("alpha", line(0.0, 1e-3), 1, compression);
  }
  static void expect(const ImportedLog& log) {
    ASSERT_EQ(log.blocks.size(), static_cast<std::size_t>(kRows));
    EXPECT_EQ(log.blocks[10].first.stamp.duration_ns, 2000000);
    EXPECT_NEAR(log.blocks[10].first.orbit.a, 1.001, 1e-12);
    EXPECT_NEAR(log.blocks[10].first.orbit.theta, 0.1, 1e-12);
    EXPECT_NEAR(log.blocks[10].second.alpha, 0.01, 1e-12);
    EXPECT_NEAR(log.blocks[10].second.reference_frequency, kTwoPi * 14e3, 1e-8);
  }

  static constexpr int kRows = 50;
  mat_t* file_ = nullptr;
};

TEST_F(MatLog, Version5) {
  open(MAT_FT_MAT5);
  addRest(MAT_COMPRESSION_NONE);
  add("theta", line(0.0, 0.01));
  add("f0", {14e3});
  close();
  expect(import({"omega=f0:Hz"}, {}, {}, "log.mat"));
}

TEST_F(MatLog, Version7Compressed) {
  open(MAT_FT_MAT5);
  addRest(MAT_COMPRESSION_ZLIB);
  Vector both = line(0.0, 0.01);
  const Vector frequency(static_cast<std::size_t>(kRows), 14e3);
  both.insert(both.end(), frequency.begin(), frequency.end());
  add("data", both, 2, MAT_COMPRESSION_ZLIB);
  close();
  expect(import({"theta=data(:,1)", "omega=data(:,2):Hz"}, {}, {}, "log.mat"));
}

TEST_F(MatLog, VectorsInAStruct) {
  open(MAT_FT_MAT5);
  addRest(MAT_COMPRESSION_NONE);
  const char* fields[] = {"angle"};
  std::size_t one[2] = {1, 1};
  std::size_t dims[2] = {1, kRows};
  matvar_t* const structure = Mat_VarCreateStruct("log", 2, one, fields, 1);
  Vector theta = line(0.0, toDegrees(0.01));
  Mat_VarSetStructFieldByName(
      structure, "angle", 0,
      Mat_VarCreate(nullptr, MAT_C_DOUBLE, MAT_T_DOUBLE, 2, dims, theta.data(), 0));
  ASSERT_EQ(Mat_VarWrite(file_, structure, MAT_COMPRESSION_NONE), 0);
  Mat_VarFree(structure);
  close();
  expect(import({"theta=log.angle:deg"}, {}, {"omega=14kHz"}, "log.mat"));
}

TEST_F(MatLog, VectorsOfUnequalLength) {
  open(MAT_FT_MAT5);
  addRest(MAT_COMPRESSION_NONE);
  add("theta", {0.0, 0.1, 0.2});
  close();
  try {
    import({}, {}, {"omega=14kHz"}, "log.mat");
    FAIL();
  } catch (const LogError& error) {
    EXPECT_TRUE(contains(error.what(), "theta: has 3 values where others have 50")) << error.what();
  }
}

TEST_F(MatLog, BrokenFile) {
  std::ofstream(path("log.mat")) << "MATLAB 5.0 MAT-file, and nothing of it";
  EXPECT_THROW(import({}, {}, {}, "log.mat"), LogError);
}

}  // namespace
}  // namespace ring_gyro
