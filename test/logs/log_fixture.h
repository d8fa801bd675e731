#pragma once

#include <gtest/gtest.h>

#include <boost/filesystem/operations.hpp>
#include <boost/filesystem/path.hpp>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "ring_gyro/logs/log_importer.h"
#include "ring_gyro/logs/record_source.h"

namespace cvg {

/// What a log was imported to.
struct ImportedLog {
  std::vector<std::pair<OrbitalElements, ControlGains>> blocks;
  ImportCounts counts;
  std::string table;
  std::string group_delay;
};

/// A folder of its own for each test, and the import of files in it.
class LogTest : public ::testing::Test {
 protected:
  LogTest() { boost::filesystem::create_directories(folder_); }
  ~LogTest() override {
    boost::system::error_code ignored;
    boost::filesystem::remove_all(folder_, ignored);
  }

  std::string path(const std::string& name = "log.csv") const { return (folder_ / name).string(); }

  void write(const std::string& text) const { std::ofstream(path(), std::ios::binary) << text; }

  ImportedLog import(const std::vector<std::string>& columns = {},
                     const ImportOptions& options = {},
                     const std::vector<std::string>& constants = {},
                     const std::string& name = "log.csv", const CsvDialect& dialect = {}) const {
    const std::unique_ptr<RecordSource> source = openLog(path(name), dialect);
    const ColumnMap map(path(name), source->names(), columns, constants);
    LogImporter importer(*source, map, options);
    ImportedLog log;
    const LogRow& first = importer.firstRow();
    log.table = map.table({first.data(), first.data() + first.size()});
    log.group_delay = importer.groupDelayText();
    log.counts = importer.run(
        [&log](const OrbitalElements& elements, const ControlGains& gains) {
          log.blocks.emplace_back(elements, gains);
        },
        nullptr);
    return log;
  }

  /// The message of the LogError that the import ends in; empty when it does not.
  std::string faultOf(const std::vector<std::string>& columns = {},
                      const ImportOptions& options = {}) const {
    try {
      import(columns, options);
      return "";
    } catch (const LogError& error) {
      return error.what();
    }
  }

 private:
  boost::filesystem::path folder_ =
      boost::filesystem::temp_directory_path() / boost::filesystem::unique_path("ring_gyro_%%%%%%");
};

inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace cvg
