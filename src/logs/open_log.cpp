#include <cstdio>
#include <cstring>

#include "ring_gyro/logs/csv_source.h"
#include "ring_gyro/logs/mat_source.h"
#include "ring_gyro/logs/record_source.h"

namespace cvg {
namespace {

bool isMatlabFile(const std::string& path) {
  char head[8] = {};
  if (std::FILE* const file = std::fopen(path.c_str(), "rb")) {
    const std::size_t count = std::fread(head, 1, sizeof head - 1, file);
    std::fclose(file);
    return count == sizeof head - 1 && std::strcmp(head, "MATLAB ") == 0;
  }
  return false;
}

}  // namespace

std::unique_ptr<RecordSource> openLog(const std::string& path, const CsvDialect& dialect) {
  if (isMatlabFile(path)) return std::make_unique<MatSource>(path);
  return std::make_unique<CsvSource>(path, dialect);
}

}  // namespace cvg
