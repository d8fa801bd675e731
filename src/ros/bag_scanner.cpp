#include "ring_gyro/ros/bag_scanner.h"

#include <bzlib.h>
#include <roslz4/lz4s.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <string_view>
#include <vector>

namespace ring_gyro {
namespace {

// http://wiki.ros.org/Bags/Format/2.0
constexpr std::string_view kMagic = "#ROSBAG V2.0\n";
constexpr std::uint8_t kMessageData = 0x02;
constexpr std::uint8_t kChunk = 0x05;
constexpr std::uint8_t kConnection = 0x07;
constexpr std::uint32_t kLargestHeader = 1u << 20;
constexpr std::uint32_t kLargestChunk = 1u << 30;

std::uint32_t littleEndian(const char* bytes) {
  std::uint32_t value;
  std::memcpy(&value, bytes, sizeof(value));
  return value;
}

/// Fields of a record or connection header: length, name, '=', value, one after the other.
class Fields {
 public:
  explicit Fields(std::string_view text) : text_(text) {}

  /// Empty when there is no such field, or what stands there is not a list of fields.
  std::string_view get(std::string_view name) const {
    std::string_view rest = text_;
    while (rest.size() >= 4) {
      const std::uint32_t length = littleEndian(rest.data());
      rest.remove_prefix(4);
      if (length > rest.size()) return {};
      const std::string_view field = rest.substr(0, length);
      rest.remove_prefix(length);
      const std::size_t equals = field.find('=');
      if (equals != std::string_view::npos && field.substr(0, equals) == name) {
        return field.substr(equals + 1);
      }
    }
    return {};
  }
  std::uint8_t op() const {
    const std::string_view value = get("op");
    return value.size() == 1 ? static_cast<std::uint8_t>(value[0]) : 0;
  }
  bool number(std::string_view name, std::uint32_t& value) const {
    const std::string_view bytes = get(name);
    if (bytes.size() != 4) return false;
    value = littleEndian(bytes.data());
    return true;
  }

 private:
  std::string_view text_;
};

/// Whether a header can be one: each record says what it is.
bool isRecord(std::string_view header) { return Fields(header).op() != 0; }

struct Record {
  std::string_view header;
  std::string_view data;
};

/// Takes a record off the front of `rest`; false when it is not whole.
bool takeRecord(std::string_view& rest, Record& record) {
  if (rest.size() < 4) return false;
  const std::size_t header = littleEndian(rest.data());
  if (rest.size() < 8 + header) return false;
  const std::size_t data = littleEndian(rest.data() + 4 + header);
  if (rest.size() < 8 + header + data) return false;
  record.header = rest.substr(4, header);
  record.data = rest.substr(8 + header, data);
  rest.remove_prefix(8 + header + data);
  return true;
}

bool decompress(std::string_view compression, std::vector<char>& packed, std::vector<char>& out) {
  auto size = static_cast<unsigned int>(out.size());
  const auto packed_size = static_cast<unsigned int>(packed.size());
  if (compression == "none") {
    if (packed.size() < out.size()) return false;
    out.swap(packed);
    return true;
  }
  if (compression == "lz4") {
    return roslz4_buffToBuffDecompress(packed.data(), packed_size, out.data(), &size) ==
               ROSLZ4_OK &&
           size == out.size();
  }
  if (compression == "bz2") {
    return BZ2_bzBuffToBuffDecompress(out.data(), &size, packed.data(), packed_size, 0, 0) ==
               BZ_OK &&
           size == out.size();
  }
  return false;
}

/// The file, record by record, without more than one in memory.
class RecordFile {
 public:
  explicit RecordFile(const std::string& path) : file_(path, std::ios::binary) {
    if (!file_) throw std::runtime_error("cannot be opened: " + std::string(std::strerror(errno)));
    file_.seekg(0, std::ios::end);
    size_ = static_cast<std::uint64_t>(file_.tellg());
    file_.seekg(0);
  }

  std::uint64_t size() const { return size_; }
  std::uint64_t position() const { return position_; }
  std::uint64_t rest() const { return size_ - position_; }

  bool takeMagic() {
    std::vector<char> bytes;
    return take(kMagic.size(), bytes) && std::string_view(bytes.data(), bytes.size()) == kMagic;
  }
  /// Header of the next record and the length of its data.
  bool takeHeader(std::vector<char>& header, std::uint32_t& data_length) {
    std::uint32_t length = 0;
    return takeLength(length) && length <= kLargestHeader && take(length, header) &&
           takeLength(data_length);
  }
  bool take(std::uint64_t count, std::vector<char>& bytes) {
    if (count > rest()) return false;
    bytes.resize(count);
    file_.read(bytes.data(), static_cast<std::streamsize>(count));
    position_ += count;
    return static_cast<bool>(file_);
  }
  /// Goes on to the next chunk that begins after `from`; to the end of the file when there is none.
  void seekChunk(std::uint64_t from) {
    constexpr std::string_view kFirstField = "compression=";
    constexpr std::size_t kBlock = 1u << 20;
    file_.clear();
    std::string block;
    for (std::uint64_t begin = from; begin < size_; begin += kBlock) {
      block.resize(std::min<std::uint64_t>(kBlock + kFirstField.size() - 1, size_ - begin));
      file_.seekg(static_cast<std::streamoff>(begin));
      file_.read(&block[0], static_cast<std::streamsize>(block.size()));
      const std::size_t found = block.find(kFirstField);
      // Before it stand its own length and that of the header.
      if (found == std::string::npos || begin + found < from + 8) continue;
      position_ = begin + found - 8;
      file_.seekg(static_cast<std::streamoff>(position_));
      return;
    }
    position_ = size_;
  }
  bool skip(std::uint64_t count) {
    if (count > rest()) return false;
    position_ += count;
    file_.seekg(static_cast<std::streamoff>(position_));
    return static_cast<bool>(file_);
  }

 private:
  bool takeLength(std::uint32_t& length) {
    std::vector<char> bytes;
    if (!take(4, bytes)) return false;
    length = littleEndian(bytes.data());
    return true;
  }

  std::ifstream file_;
  std::uint64_t size_ = 0;
  std::uint64_t position_ = 0;
};

std::string_view view(const std::vector<char>& bytes) { return {bytes.data(), bytes.size()}; }

}  // namespace

std::string bagEncryptor(const std::string& path) {
  RecordFile file(path);
  std::vector<char> header;
  std::uint32_t data_length = 0;
  if (!file.takeMagic() || !file.takeHeader(header, data_length)) return "";
  return std::string(Fields(view(header)).get("encryptor"));
}

BagScan BagScanner::scan(const std::string& path) const {
  RecordFile file(path);
  BagScan result;
  result.file_bytes = file.size();
  const auto lose = [&result](std::uint64_t where, std::uint64_t count) {
    if (result.lost_bytes == 0) result.first_lost = where;
    result.lost_bytes += count;
  };
  const auto readRecord = [this, &result](const Record& record) {
    const Fields fields(record.header);
    std::uint32_t id = 0;
    if (!fields.number("conn", id)) return;
    if (fields.op() == kConnection) {
      const Fields about(record.data);
      if (on_connection) {
        on_connection({id, std::string(fields.get("topic")), std::string(about.get("type")),
                       std::string(about.get("md5sum"))});
      }
    } else if (fields.op() == kMessageData) {
      const std::string_view stamp = fields.get("time");
      if (stamp.size() != 8) return;
      const ros::Time time(littleEndian(stamp.data()), littleEndian(stamp.data() + 4));
      ++result.messages;
      result.begin = std::min(result.begin, time);
      result.end = std::max(result.end, time);
      if (on_message) {
        // Readers of messages want bytes that they could change; they do not.
        auto* bytes =
            const_cast<std::uint8_t*>(reinterpret_cast<const std::uint8_t*>(record.data.data()));
        on_message(id, time, bytes, static_cast<std::uint32_t>(record.data.size()));
      }
    }
  };

  std::vector<char> header;
  std::vector<char> packed;
  std::vector<char> chunk;
  if (!file.takeMagic()) throw std::runtime_error("not a bag of format 2.0");
  while (file.rest() > 0) {
    const std::uint64_t begin = file.position();
    std::uint32_t length = 0;
    if (!file.takeHeader(header, length) || length > file.rest() || !isRecord(view(header))) {
      file.seekChunk(begin + 1);
      lose(begin, file.position() - begin);
      continue;
    }
    const Fields fields(view(header));
    if (fields.op() != kChunk) {
      if (fields.op() == kConnection && file.take(length, packed)) {
        readRecord({view(header), view(packed)});
      } else {
        file.skip(length);
      }
      continue;
    }
    std::uint32_t size = 0;
    if (!fields.number("size", size) || size > kLargestChunk || length > kLargestChunk ||
        (length == 0 && size == 0)) {
      // A recorder fills in the lengths when the chunk is full: the one it was at has none.
      file.seekChunk(begin + 16);
      lose(begin, file.position() - begin);
      continue;
    }
    chunk.resize(size);
    if (!file.take(length, packed) || !decompress(fields.get("compression"), packed, chunk)) {
      lose(begin, file.position() - begin);
      continue;
    }
    std::string_view rest = view(chunk);
    Record record;
    while (takeRecord(rest, record)) readRecord(record);
    if (!rest.empty()) lose(begin, rest.size());
  }
  return result;
}

}  // namespace ring_gyro
