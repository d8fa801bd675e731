#pragma once

#include <ros/time.h>

#include <cstdint>
#include <cstring>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

namespace ring_gyro::bridge {

// Records of a bag, format 2.0: http://wiki.ros.org/Bags/Format/2.0

enum class BagOp : std::uint8_t {
  kNone = 0,
  kMessageData = 2,
  kBagHeader = 3,
  kIndexData = 4,
  kChunk = 5,
  kChunkInfo = 6,
  kConnection = 7
};

/// Fields of a record's header, or of the data of a connection.
class BagFields {
 public:
  explicit BagFields(std::string_view text) : text_(text) {}

  /// Empty when there is no such field, or the bytes are not a list of fields.
  std::string_view get(std::string_view name) const;
  BagOp op() const;
  /// False when the field is missing or has another length.
  template <typename Number>
  bool number(std::string_view name, Number& value) const {
    const std::string_view bytes = get(name);
    if (bytes.size() != sizeof value) return false;
    std::memcpy(&value, bytes.data(), sizeof value);
    return true;
  }
  bool time(std::string_view name, ros::Time& value) const;

 private:
  std::string_view text_;
};

/// Time in the format of a bag: seconds, nanoseconds, four bytes each.
ros::Time bagTime(const char* bytes);

struct BagRecord {
  std::string_view header;
  std::string_view data;
};

/// Takes the first record off `rest`; false when it is not complete.
bool takeRecord(std::string_view& rest, BagRecord& record);

/// A message within a chunk.
struct ChunkMessage {
  std::uint32_t connection = 0;
  ros::Time time;
  std::string_view bytes;  ///< serialised
};

/// False when the record is not a message; otherwise gives the message.
bool asMessage(const BagRecord& record, ChunkMessage& message);

/// Reads a bag record by record, with at most one record in memory.
class BagRecordFile {
 public:
  /// Moves to the first record. Throws std::runtime_error when the file cannot be opened or is not
  /// a bag of format 2.0.
  explicit BagRecordFile(const std::string& path);

  std::uint64_t size() const { return size_; }
  std::uint64_t position() const { return position_; }
  std::uint64_t rest() const { return size_ - position_; }

  /// Header of the next record and the length of its data. False, as below, if there is no more.
  bool takeHeader(std::string& header, std::uint32_t& data_length);
  bool take(std::uint64_t count, std::string& bytes);
  bool skip(std::uint64_t count) { return count <= rest() && seek(position_ + count); }
  bool seek(std::uint64_t position);
  /// Moves to the next chunk that begins after `from`, or to the end of the file if there is none.
  void seekChunk(std::uint64_t from);

 private:
  bool takeLength(std::uint32_t& length);

  std::ifstream file_;
  std::uint64_t size_ = 0;
  std::uint64_t position_ = 0;
};

enum class ChunkState {
  kWhole,
  kNoHeader,   ///< no header, so its length is unknown
  kUnreadable  ///< its data do not fit its header
};

/// Takes the data of a chunk whose header has been taken; `packed` is working memory.
ChunkState takeChunk(BagRecordFile& file, const std::string& header, std::uint32_t data_length,
                     std::string& packed, std::string& chunk);

}  // namespace ring_gyro::bridge
