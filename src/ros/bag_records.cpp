#include "ring_gyro/ros/bag_records.h"

#include <bzlib.h>
#include <roslz4/lz4s.h>

#include <algorithm>
#include <cerrno>
#include <stdexcept>

namespace ring_gyro::bridge {
namespace {

constexpr std::string_view kMagic = "#ROSBAG V2.0\n";
constexpr std::uint32_t kLargestHeader = 1u << 20;
constexpr std::uint32_t kLargestChunk = 1u << 30;

std::uint32_t littleEndian(const char* bytes) {
  std::uint32_t value;
  std::memcpy(&value, bytes, sizeof(value));
  return value;
}

bool decompress(std::string_view compression, std::string& packed, std::string& out) {
  auto size = static_cast<unsigned int>(out.size());
  const auto packed_size = static_cast<unsigned int>(packed.size());
  if (compression == "none") {
    if (packed.size() < out.size()) return false;
    packed.resize(out.size());
    out.swap(packed);
    return true;
  }
  if (compression == "lz4") {
    return roslz4_buffToBuffDecompress(&packed[0], packed_size, &out[0], &size) == ROSLZ4_OK &&
           size == out.size();
  }
  if (compression == "bz2") {
    return BZ2_bzBuffToBuffDecompress(&out[0], &size, &packed[0], packed_size, 0, 0) == BZ_OK &&
           size == out.size();
  }
  return false;
}

}  // namespace

std::string_view BagFields::get(std::string_view name) const {
  std::string_view rest = text_;
  while (rest.size() >= 4) {
    const std::uint32_t length = littleEndian(rest.data());
    rest.remove_prefix(4);
    if (length > rest.size()) return {};
    const std::string_view field = rest.substr(0, length);
    rest.remove_prefix(length);
    if (field.size() > name.size() && field[name.size()] == '=' &&
        field.compare(0, name.size(), name) == 0) {
      return field.substr(name.size() + 1);
    }
  }
  return {};
}

BagOp BagFields::op() const {
  const std::string_view value = get("op");
  return value.size() == 1 ? static_cast<BagOp>(value[0]) : BagOp::kNone;
}

bool BagFields::time(std::string_view name, ros::Time& value) const {
  const std::string_view bytes = get(name);
  if (bytes.size() != 8) return false;
  value = bagTime(bytes.data());
  return true;
}

ros::Time bagTime(const char* bytes) {
  // Not by the constructor, which throws on nanoseconds above a second.
  ros::Time time;
  time.sec = littleEndian(bytes);
  time.nsec = littleEndian(bytes + 4);
  return time;
}

bool takeRecord(std::string_view& rest, BagRecord& record) {
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

bool asMessage(const BagRecord& record, ChunkMessage& message) {
  const BagFields fields(record.header);
  if (fields.op() != BagOp::kMessageData || !fields.number("conn", message.connection) ||
      !fields.time("time", message.time)) {
    return false;
  }
  message.bytes = record.data;
  return true;
}

BagRecordFile::BagRecordFile(const std::string& path) : file_(path, std::ios::binary) {
  if (!file_) throw std::runtime_error("cannot be opened: " + std::string(std::strerror(errno)));
  file_.seekg(0, std::ios::end);
  size_ = static_cast<std::uint64_t>(file_.tellg());
  file_.seekg(0);
  std::string magic;
  if (!take(kMagic.size(), magic) || magic != kMagic) {
    throw std::runtime_error("not a bag of format 2.0");
  }
}

bool BagRecordFile::takeHeader(std::string& header, std::uint32_t& data_length) {
  std::uint32_t length = 0;
  return takeLength(length) && length <= kLargestHeader && take(length, header) &&
         takeLength(data_length);
}

bool BagRecordFile::take(std::uint64_t count, std::string& bytes) {
  if (count > rest()) return false;
  bytes.resize(count);
  file_.read(&bytes[0], static_cast<std::streamsize>(count));
  position_ += count;
  return static_cast<bool>(file_);
}

bool BagRecordFile::seek(std::uint64_t position) {
  if (position > size_) return false;
  position_ = position;
  file_.clear();
  file_.seekg(static_cast<std::streamoff>(position_));
  return static_cast<bool>(file_);
}

void BagRecordFile::seekChunk(std::uint64_t from) {
  constexpr std::string_view kFirstField = "compression=";
  constexpr std::size_t kBlock = 1u << 20;
  std::string block;
  for (std::uint64_t begin = from; begin < size_; begin += kBlock) {
    seek(begin);
    block.resize(std::min<std::uint64_t>(kBlock + kFirstField.size() - 1, size_ - begin));
    file_.read(&block[0], static_cast<std::streamsize>(block.size()));
    const std::size_t found = block.find(kFirstField);
    // The two lengths, of the field and of the header, are before it.
    if (found == std::string::npos || begin + found < from + 8) continue;
    seek(begin + found - 8);
    return;
  }
  seek(size_);
}

bool BagRecordFile::takeLength(std::uint32_t& length) {
  char bytes[4];
  if (rest() < sizeof bytes) return false;
  file_.read(bytes, sizeof bytes);
  position_ += sizeof bytes;
  length = littleEndian(bytes);
  return static_cast<bool>(file_);
}

ChunkState takeChunk(BagRecordFile& file, const std::string& header, std::uint32_t data_length,
                     std::string& packed, std::string& chunk) {
  const BagFields fields(header);
  std::uint32_t size = 0;
  // A recorder writes the lengths when a chunk is full, so its last chunk may have none.
  if (fields.op() != BagOp::kChunk || !fields.number("size", size) || size > kLargestChunk ||
      data_length > kLargestChunk || (data_length == 0 && size == 0)) {
    return ChunkState::kNoHeader;
  }
  chunk.resize(size);
  if (!file.take(data_length, packed) || !decompress(fields.get("compression"), packed, chunk)) {
    return ChunkState::kUnreadable;
  }
  return ChunkState::kWhole;
}

}  // namespace ring_gyro::bridge
