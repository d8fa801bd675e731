#include "line_batch.h"

#include <boost/program_options.hpp>
#include <cerrno>
#include <cinttypes>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "ring_gyro/common/output_target.h"
#include "ring_gyro/common/whole_file.h"

namespace ring_gyro::tools {
namespace {

using Json = nlohmann::ordered_json;

std::string contentOf(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  file.peek();  // a folder can be opened, but not read
  if (file.bad() || !file.is_open()) {
    throw std::runtime_error(path + ": cannot be read: " + std::strerror(errno));
  }
  file.clear();
  std::ostringstream content;
  content << file.rdbuf();
  return content.str();
}

/// Adds the lines of a file; returns the position at which the last complete line ends.
std::size_t readLines(const std::string& program, const std::string& path, const LineCheck& check,
                      LinesByIndex& lines) {
  const std::string text = contentOf(path);
  std::size_t whole = 0;
  std::size_t number = 0;
  for (std::size_t end = text.find('\n'); end != std::string::npos; end = text.find('\n', whole)) {
    const std::string where = path + ":" + std::to_string(++number) + ": ";
    const std::string line = text.substr(whole, end + 1 - whole);
    whole = end + 1;
    std::uint64_t index = 0;
    try {
      const Json json = Json::parse(line);
      index = json.at("index");
      check(index, json);
    } catch (const Json::exception& error) {
      throw std::runtime_error(where + "no line of " + program + ": " + error.what());
    } catch (const std::runtime_error& error) {
      throw std::runtime_error(where + error.what());
    }
    const auto place = lines.emplace(index, line);
    if (place.first->second != line) {
      throw std::runtime_error(where + "item " + std::to_string(index) +
                               " is there twice and differs: run by different builds?");
    }
  }
  return whole;
}

}  // namespace

void setShard(const std::string& text, cvg::ItemRange& range) {
  char end = '\0';
  if (text.empty()) return;
  if (std::sscanf(text.c_str(), "%" SCNu64 "/%" SCNu64 "%c", &range.shard, &range.shards, &end) !=
          2 ||
      text.find('-') != std::string::npos || range.shard >= range.shards) {
    throw boost::program_options::error("--shard " + text + ": must be K/N, K from 0 to N - 1");
  }
}

LinesByIndex mergeLines(const std::string& program, const std::vector<std::string>& files,
                        const std::string& output, const LineCheck& check) {
  cvg::requireApart({output}, files);
  cvg::WholeFile merged(output);
  LinesByIndex lines;
  for (const std::string& path : files) readLines(program, path, check, lines);
  for (const auto& line : lines) merged.write(line.second);
  merged.finish();
  return lines;
}

LineBatch::LineBatch(const std::string& program, const std::string& path, bool resume,
                     const LineCheck& check)
    : file_(path) {
  if (resume && !file_.isFile()) {
    throw std::runtime_error(path + ": is no file; leave --resume out");
  }
  if (resume) {
    file_.cutAt(readLines(program, path, check, lines_));
  } else if (!file_.empty()) {
    throw std::runtime_error(path +
                             ": is there already; add --resume to go on, or name another file");
  }
}

std::vector<std::uint64_t> LineBatch::left(const cvg::ItemRange& range) const {
  std::vector<std::uint64_t> left;
  for (const std::uint64_t index : range.indices()) {
    if (lines_.count(index) == 0) left.push_back(index);
  }
  return left;
}

void LineBatch::add(std::uint64_t index, const std::string& line) {
  file_.add(line);
  lines_.emplace(index, line);
}

std::string asLine(const Json& item) {
  return item.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace ring_gyro::tools
