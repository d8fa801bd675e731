#include <hdf5.h>
#include <matio.h>
#include <sys/resource.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <memory>

#include "logs/log_fixture.h"
#include "ring_gyro/common/angle.h"

namespace cvg {
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

/// While it lives this process gets 64 MB at most beyond what it has. Sanitizers reserve what they
/// like: with them there is no limit.
class MemoryLimit {
 public:
  MemoryLimit() {
    getrlimit(RLIMIT_AS, &before_);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
    std::size_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    rlimit limit = before_;
    limit.rlim_cur = pages * static_cast<rlim_t>(sysconf(_SC_PAGESIZE)) + (rlim_t{64} << 20);
    EXPECT_EQ(setrlimit(RLIMIT_AS, &limit), 0);
#endif
  }
  ~MemoryLimit() { setrlimit(RLIMIT_AS, &before_); }
  MemoryLimit(const MemoryLimit&) = delete;
  MemoryLimit& operator=(const MemoryLimit&) = delete;

 private:
  rlimit before_{};
};

/// A file as it was read: the same numbers, or why it was not.
struct Reading {
  std::vector<std::vector<double>> rows;
  std::string fault;
};

class DamagedMatLog : public MatLog {
 protected:
  void writeWhole(mat_ft version, matio_compression compression) {
    open(version);
    addRest(compression);
    add("theta", line(0.0, 0.01), 1, compression);
    add("omega", line(kTwoPi * 14e3, 0.0), 1, compression);
    const char* fields[] = {"angle", "b"};
    std::size_t one[2] = {1, 1};
    std::size_t dims[2] = {kRows, 1};
    matvar_t* const structure = Mat_VarCreateStruct("log", 2, one, fields, 2);
    for (const char* field : fields) {
      Vector values = line(0.0, 0.5);
      Mat_VarSetStructFieldByName(
          structure, field, 0,
          Mat_VarCreate(nullptr, MAT_C_DOUBLE, MAT_T_DOUBLE, 2, dims, values.data(), 0));
    }
    ASSERT_EQ(Mat_VarWrite(file_, structure, compression), 0);
    Mat_VarFree(structure);
    close();
  }
  std::string bytes(const std::string& name = "log.mat") const {
    std::ifstream file(path(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  void put(const std::string& content) const {
    std::ofstream(path("log.mat"), std::ios::binary) << content;
  }
  /// Everything of the simplest form, and nothing that could be missing unnoticed.
  static Reading read(const std::string& file) {
    Reading reading;
    const MemoryLimit limit;
    try {
      const std::unique_ptr<RecordSource> source = openLog(file);
      const ColumnMap map(file, source->names(), {});
      map.requireComplete(false);
      std::vector<std::size_t> columns;
      for (const QuantityInfo& info : quantities()) {
        if (map.has(info.quantity)) columns.push_back(*map.use(info.quantity)->column);
      }
      source->select(columns);
      std::vector<double> row;
      while (source->next(row)) reading.rows.push_back(row);
    } catch (const LogError& error) {
      reading.fault = error.what();
      EXPECT_EQ(reading.fault.find('\n'), std::string::npos) << reading.fault;
      EXPECT_NE(reading.fault.find("log.mat"), std::string::npos) << reading.fault;
    }
    return reading;
  }
  Reading read() const { return read(path("log.mat")); }

  /// Copies that end anywhere: refused, or the same to the last bit.
  void expectCutsAreRefused(std::size_t step) {
    const std::string whole = bytes();
    const Reading all = read();
    ASSERT_EQ(all.fault, "");
    ASSERT_EQ(all.rows.size(), static_cast<std::size_t>(kRows));
    std::size_t refused = 0;
    for (std::size_t length = whole.size(); length-- > 0;) {
      if (length % step != 0) continue;
      ASSERT_EQ(::truncate(path("log.mat").c_str(), static_cast<off_t>(length)), 0);
      const Reading cut = read();
      if (cut.fault.empty()) {
        ASSERT_EQ(cut.rows, all.rows) << length << " of " << whole.size();
      } else {
        ++refused;
      }
    }
    EXPECT_GT(refused, 0.6 * static_cast<double>(whole.size() / step));
  }
};

TEST_F(DamagedMatLog, Version5CutAnywhere) {
  writeWhole(MAT_FT_MAT5, MAT_COMPRESSION_NONE);
  expectCutsAreRefused(1);
  writeWhole(MAT_FT_MAT5, MAT_COMPRESSION_NONE);
  put(bytes().substr(0, 128 + 3 * 450));
  EXPECT_TRUE(contains(read().fault, "log.mat, variable b: is cut: 400 bytes are to follow"))
      << read().fault;
}

TEST_F(DamagedMatLog, Version7CutAnywhere) {
  writeWhole(MAT_FT_MAT5, MAT_COMPRESSION_ZLIB);
  expectCutsAreRefused(1);
  writeWhole(MAT_FT_MAT5, MAT_COMPRESSION_ZLIB);
  put(bytes().substr(0, bytes().size() - 20));
  EXPECT_TRUE(contains(read().fault, "log.mat, variable log: is cut in its compressed data"))
      << read().fault;
}

TEST_F(DamagedMatLog, Version73CutAnywhere) {
  writeWhole(MAT_FT_MAT73, MAT_COMPRESSION_NONE);
  expectCutsAreRefused(7);
  writeWhole(MAT_FT_MAT73, MAT_COMPRESSION_ZLIB);
  expectCutsAreRefused(7);
}

TEST_F(DamagedMatLog, Version4IsNotReadAtAnyLength) {
  open(MAT_FT_MAT4);
  addRest(MAT_COMPRESSION_NONE);
  close();
  const std::string whole = bytes();
  for (std::size_t length = 0; length <= whole.size(); length += 16) {
    put(whole.substr(0, length));
    EXPECT_NE(read().fault, "") << length;
  }
}

/// The tags, dimensions and names of the first variable and of the struct, with other bits. Of the
/// data themselves any bit may be anything.
TEST_F(DamagedMatLog, NoBitOfTheStructureTakesTheReaderAway) {
  for (const matio_compression compression : {MAT_COMPRESSION_NONE, MAT_COMPRESSION_ZLIB}) {
    writeWhole(MAT_FT_MAT5, compression);
    const std::string whole = bytes();
    const std::size_t last = compression == MAT_COMPRESSION_NONE ? 1100 : 200;
    std::fstream file(path("log.mat"), std::ios::binary | std::ios::in | std::ios::out);
    const auto change = [&file](std::size_t at, int byte) {
      file.seekp(static_cast<std::streamoff>(at));
      file.put(static_cast<char>(byte)).flush();
    };
    for (std::size_t k = 124; k < whole.size(); ++k) {
      const bool in_head = k < 200 || (k > whole.size() - last && k < whole.size() - last + 250);
      if (!in_head) continue;
      for (const int bits : {0x80, 0x03}) {
        change(k, whole[k] ^ bits);
        read();
      }
      change(k, whole[k]);
    }
    EXPECT_EQ(read().fault, "");
  }
}

void append(std::string& text, std::uint32_t value) {
  for (int k = 0; k < 4; ++k) text += static_cast<char>((value >> (8 * k)) & 0xff);
}

/// An array of doubles that claims these dimensions and holds two numbers.
std::string claiming(std::uint32_t rows, std::uint32_t columns, std::uint32_t kind = 6) {
  std::string body;
  for (const std::uint32_t word : {6U, 8U, kind, 0U, 5U, 8U, rows, columns}) append(body, word);
  append(body, 0x00010001);
  body += std::string("t\0\0\0", 4);
  for (const std::uint32_t word : {9U, 16U, 0U, 0x3ff00000U, 0U, 0x40000000U}) append(body, word);
  std::string array;
  append(array, 14);
  append(array, static_cast<std::uint32_t>(body.size()));
  return array + body;
}

std::string compressed(const std::string& plain) {
  std::vector<Bytef> packed(compressBound(plain.size()));
  uLongf size = packed.size();
  EXPECT_EQ(
      compress(packed.data(), &size, reinterpret_cast<const Bytef*>(plain.data()), plain.size()),
      Z_OK);
  std::string element;
  append(element, 15);
  append(element, static_cast<std::uint32_t>(size));
  return element.append(reinterpret_cast<const char*>(packed.data()), size);
}

TEST_F(DamagedMatLog, ClaimsWithoutDataAreRefusedBeforeMemoryIsTaken) {
  std::string header = "MATLAB 5.0 MAT-file";
  header.resize(124, ' ');
  header += std::string("\0\1IM", 4);
  for (const auto& [rows, columns] : std::vector<std::pair<std::uint32_t, std::uint32_t>>{
           {1150000000, 1}, {1, 0x7fffffff}, {0x7fffffff, 0x7fffffff}, {3, 1}, {0, 5}}) {
    for (const std::uint32_t kind : {6U, 0x806U, 1U, 2U, 4U, 7U}) {
      for (const bool packed : {false, true}) {
        const std::string array = claiming(rows, columns, kind);
        put(header + (packed ? compressed(array) : array));
        const std::string fault = read().fault;
        EXPECT_NE(fault, "") << rows << " " << columns << " " << kind;
        if (kind == 6 && rows > 0) {
          EXPECT_TRUE(contains(fault, "variable t: claims")) << fault;
        }
      }
    }
  }
  put(header + claiming(0xffffffff, 1));
  EXPECT_TRUE(contains(read().fault, "variable t: claims a negative dimension")) << read().fault;
}

TEST_F(DamagedMatLog, NestingHasAnEnd) {
  std::string header = "MATLAB 5.0 MAT-file";
  header.resize(124, ' ');
  header += std::string("\0\1IM", 4);
  std::string array = claiming(2, 1);
  for (int k = 0; k < 5000; ++k) {
    std::string body;
    for (const std::uint32_t word : {6U, 8U, 1U, 0U, 5U, 8U, 1U, 1U, 0x00010001U, 0x63U}) {
      append(body, word);
    }
    body += array;
    array.clear();
    append(array, 14);
    append(array, static_cast<std::uint32_t>(body.size()));
    array += body;
  }
  put(header + array);
  EXPECT_TRUE(contains(read().fault, "variable c: has arrays in arrays")) << read().fault;
}

/// A dataset of HDF5 has no data until they are written: it reads as zeros.
TEST_F(DamagedMatLog, Version73ThatClaimsWhatWasNeverWritten) {
  for (const bool chunks : {false, true}) {
    writeWhole(MAT_FT_MAT73, MAT_COMPRESSION_NONE);
    const hid_t file = H5Fopen(path("log.mat").c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    ASSERT_GE(file, 0);
    ASSERT_GE(H5Ldelete(file, "theta", H5P_DEFAULT), 0);
    const hsize_t dimensions[2] = {1, 1150000000};
    const hsize_t chunk[2] = {1, 1000000};
    const hid_t space = H5Screate_simple(2, dimensions, nullptr);
    const hid_t layout = H5Pcreate(H5P_DATASET_CREATE);
    if (chunks) {
      H5Pset_chunk(layout, 2, chunk);
      H5Pset_deflate(layout, 5);
    } else {
      H5Pset_alloc_time(layout, H5D_ALLOC_TIME_LATE);
    }
    const hid_t dataset =
        H5Dcreate2(file, "theta", H5T_IEEE_F64LE, space, H5P_DEFAULT, layout, H5P_DEFAULT);
    ASSERT_GE(dataset, 0);
    if (chunks) {  // one of 1150
      const hsize_t start[2] = {0, 0};
      const std::vector<double> zeros(1000000);
      const hid_t part = H5Screate_simple(2, chunk, nullptr);
      H5Sselect_hyperslab(space, H5S_SELECT_SET, start, nullptr, chunk, nullptr);
      EXPECT_GE(H5Dwrite(dataset, H5T_NATIVE_DOUBLE, part, space, H5P_DEFAULT, zeros.data()), 0);
      H5Sclose(part);
    }
    H5Dclose(dataset);
    H5Pclose(layout);
    H5Sclose(space);
    H5Fclose(file);
    const std::string fault = read().fault;
    EXPECT_TRUE(contains(fault, "variable theta: claims")) << fault;
  }
}

/// MATLAB's way to write an empty array of 7.3: the numbers are its dimensions.
TEST_F(DamagedMatLog, Version73EmptyOfManyRows) {
  writeWhole(MAT_FT_MAT73, MAT_COMPRESSION_NONE);
  const hid_t file = H5Fopen(path("log.mat").c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  ASSERT_GE(H5Ldelete(file, "theta", H5P_DEFAULT), 0);
  const hsize_t two = 2;
  const std::uint64_t dimensions[2] = {1150000000, 1};
  const hid_t space = H5Screate_simple(1, &two, nullptr);
  const hid_t dataset =
      H5Dcreate2(file, "theta", H5T_STD_U64LE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  ASSERT_GE(H5Dwrite(dataset, H5T_NATIVE_UINT64, H5S_ALL, H5S_ALL, H5P_DEFAULT, dimensions), 0);
  const hid_t scalar = H5Screate(H5S_SCALAR);
  const hid_t text = H5Tcopy(H5T_C_S1);
  H5Tset_size(text, 6);
  const hid_t kind = H5Acreate2(dataset, "MATLAB_class", text, scalar, H5P_DEFAULT, H5P_DEFAULT);
  ASSERT_GE(H5Awrite(kind, text, "double"), 0);
  const hid_t empty =
      H5Acreate2(dataset, "MATLAB_empty", H5T_STD_U8LE, scalar, H5P_DEFAULT, H5P_DEFAULT);
  const unsigned char one = 1;
  ASSERT_GE(H5Awrite(empty, H5T_NATIVE_UCHAR, &one), 0);
  H5Aclose(empty);
  H5Aclose(kind);
  H5Tclose(text);
  H5Sclose(scalar);
  H5Dclose(dataset);
  H5Sclose(space);
  H5Fclose(file);
  EXPECT_TRUE(contains(read().fault, "variable theta: claims 1.15e+09 numbers and holds 0") ||
              contains(read().fault, "variable theta: claims 1150000000 numbers and holds 0"))
      << read().fault;
}

TEST_F(DamagedMatLog, NamesAreShownInOneLine) {
  std::string header = "MATLAB 5.0 MAT-file";
  header.resize(124, ' ');
  header += std::string("\0\1IM", 4);
  std::string array = claiming(3, 1);
  array[array.find("t\0", 40)] = '\n';
  put(header + array);
  EXPECT_TRUE(contains(read().fault, "variable ?: claims 3 numbers and holds 2")) << read().fault;
}

TEST_F(DamagedMatLog, HeaderOfNoKnownVersion) {
  writeWhole(MAT_FT_MAT5, MAT_COMPRESSION_NONE);
  const std::string whole = bytes();
  for (const std::size_t at : {124U, 125U, 126U, 127U}) {
    std::string changed = whole;
    changed[at] = static_cast<char>(changed[at] ^ 0x40);
    put(changed);
    EXPECT_TRUE(contains(read().fault, "has a damaged header")) << read().fault;
  }
}

TEST_F(MatLog, AbsurdValuesNameRowColumnAndRange) {
  open(MAT_FT_MAT5);
  addRest(MAT_COMPRESSION_NONE);
  Vector theta = line(0.0, 0.01);
  theta[7] = 1e300;
  add("theta", theta);
  close();
  try {
    import({}, {}, {"omega=14kHz"}, "log.mat");
    FAIL();
  } catch (const LogError& error) {
    EXPECT_TRUE(contains(error.what(),
                         "log.mat, row 8, column theta: theta = 1e+300 rad is out of range; "
                         "allowed: [-1e+08, 1e+08] rad"))
        << error.what();
  }
}

TEST_F(MatLog, BrokenFile) {
  std::ofstream(path("log.mat")) << "MATLAB 5.0 MAT-file, and nothing of it";
  EXPECT_THROW(import({}, {}, {}, "log.mat"), LogError);
}

}  // namespace
}  // namespace cvg
