#pragma once

#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace cvg {

/// Lines of a text file of any size in bounded memory: LF, CRLF or CR, without a byte order mark.
class LineReader {
 public:
  /// Throws LogError when the file cannot be read, is empty or is not 8-bit text.
  explicit LineReader(std::string path);

  /// False at the end. The view is valid until the next call. Throws LogError.
  bool next(std::string_view& line);
  /// Number from 1 of the last line.
  std::uint64_t number() const { return number_; }
  /// Whether the last line had no line end because the file ended.
  bool cut() const { return cut_; }
  double done() const { return static_cast<double>(read_ - (end_ - begin_)); }
  double size() const { return size_; }
  const std::string& path() const { return path_; }

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  bool fill();

  std::string path_;
  std::unique_ptr<std::FILE, Close> file_;
  std::vector<char> buffer_;
  std::size_t begin_ = 0;  // of the text not returned yet
  std::size_t end_ = 0;
  std::uint64_t read_ = 0;
  std::uint64_t number_ = 0;
  double size_ = 0.0;
  bool ended_ = false;
  bool cut_ = false;
  bool skip_line_feed_ = false;
};

}  // namespace cvg
