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

  /// Empty when there is no such field, or what stands there is not a list of fields.
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

/// Time as it stands in a bag: seconds, nanoseconds, four bytes each.
ros::Time bagTime(const char* bytes);

struct BagRecord {
  std::string_view header;
  std::string_view data;
};

/// Takes a record off the front of `rest`; false when it is not whole.
bool takeRecord(std::string_view& rest, BagRecord& record);

/// A message within a chunk.
struct ChunkMessage {
  std::uint32_t connection = 0;
  ros::Time time;
  std::string_view bytes;  ///< serialised
};

/// Whether the record is a message, and which.
bool asMessage(const BagRecord& record, ChunkMessage& message);

/// A bag, record by record, without more than one in memory.
class BagRecordFile {
 public:
  /// Throws std::runtime_error when it cannot be opened or is no bag of format 2.0. Stands at the
  /// first record then.
  explicit BagRecordFile(const std::string& path);

  std::uint64_t size() const { return size_; }
  std::uint64_t position() const { return position_; }
  std::uint64_t rest() const { return size_ - position_; }

  /// Header of the next record and the length of its data. False, as below: there is none.
  bool takeHeader(std::string& header, std::uint32_t& data_length);
  bool take(std::uint64_t count, std::string& bytes);
  bool skip(std::uint64_t count) { return count <= rest() && seek(position_ + count); }
  bool seek(std::uint64_t position);
  /// Goes on to the next chunk that begins after `from`; to the end of the file when there is none.
  void seekChunk(std::uint64_t from);

 private:
  bool takeLength(std::uint32_t& length);

  std::ifstream file_;
  std::uint64_t size_ = 0;
  std::uint64_t position_ = 0;
};

enum class ChunkState {
  kWhole,
  kNoHeader,   ///< nothing tells how long it is
  kUnreadable  ///< its data are not what its header says
};

/// Takes the data of a chunk whose header has been taken; `packed` is room to work in.
ChunkState takeChunk(BagRecordFile& file, const std::string& header, std::uint32_t data_length,
                     std::string& packed, std::string& chunk);

}  // namespace ring_gyro::bridge
