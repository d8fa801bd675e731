#include "ring_gyro/logs/line_reader.h"

#include <cerrno>
#include <cstring>
#include <utility>

#include "ring_gyro/logs/log_error.h"

namespace cvg {
namespace {

constexpr std::size_t kChunk = std::size_t{1} << 18;
constexpr std::size_t kLongestLine = std::size_t{1} << 20;

}  // namespace

LineReader::LineReader(std::string path)
    : path_(std::move(path)), file_(std::fopen(path_.c_str(), "rb")) {
  if (!file_) {
    throw LogError(path_, "", std::string("cannot be read: ") + std::strerror(errno), "");
  }
  if (std::fseek(file_.get(), 0, SEEK_END) == 0) {
    size_ = static_cast<double>(std::ftell(file_.get()));
    std::rewind(file_.get());
  }
  std::setvbuf(file_.get(), nullptr, _IONBF, 0);  // this class has its own buffer
  if (!fill()) throw LogError(path_, "", "is empty", "give a file with a table in it");
  const std::string_view head(buffer_.data(), end_);
  if (head.substr(0, 3) == "\xEF\xBB\xBF") {
    begin_ = 3;
  } else if (head.substr(0, 2) == "\xFF\xFE" || head.substr(0, 2) == "\xFE\xFF") {
    throw LogError(path_, "", "is UTF-16 text",
                   "convert it with iconv -f UTF-16 -t UTF-8 (or save it as plain CSV)");
  } else if (head.substr(0, 4096).find('\0') != std::string_view::npos) {
    throw LogError(path_, "", "is no text",
                   "give a text log, or a MATLAB file of version 5 to 7.3");
  }
}

bool LineReader::fill() {
  if (ended_) return false;
  if (begin_ > 0) {
    std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
    end_ -= begin_;
    begin_ = 0;
  }
  buffer_.resize(end_ + kChunk);
  const std::size_t count = std::fread(buffer_.data() + end_, 1, kChunk, file_.get());
  if (count < kChunk) {
    if (std::ferror(file_.get()) != 0) {
      throw LogError(path_, "", std::string("cannot be read: ") + std::strerror(errno), "");
    }
    ended_ = true;
  }
  end_ += count;
  read_ += count;
  return count > 0;
}

bool LineReader::next(std::string_view& line) {
  std::size_t searched = 0;
  for (;;) {
    if (skip_line_feed_ && begin_ < end_) {
      if (buffer_[begin_] == '\n') ++begin_;
      skip_line_feed_ = false;
    }
    const std::string_view rest(buffer_.data() + begin_, end_ - begin_);
    const std::size_t stop = rest.find_first_of("\r\n", searched);
    if (stop != std::string_view::npos) {
      line = rest.substr(0, stop);
      begin_ += stop + 1;
      skip_line_feed_ = rest[stop] == '\r';
      break;
    }
    searched = rest.size();
    if (searched > kLongestLine) {
      throw LogError(path_, "line " + std::to_string(number_ + 1), "is longer than 1 MiB",
                     "give a table with a line for each row");
    }
    if (fill()) continue;
    if (begin_ == end_) return false;
    line = {buffer_.data() + begin_, end_ - begin_};
    begin_ = end_;
    cut_ = true;
    break;
  }
  ++number_;
  return true;
}

}  // namespace cvg
