#include "ring_gyro/ros/bag_contents.h"

#include <algorithm>
#include <map>
#include <stdexcept>
#include <string_view>

#include "ring_gyro/ros/bag_records.h"

namespace ring_gyro::bridge {
namespace {

/// Connections by id; the first record of each is used.
using Connections = std::map<std::uint32_t, BagConnection>;

bool takeConnection(const BagRecord& record, Connections& connections) {
  const BagFields fields(record.header);
  std::uint32_t id = 0;
  if (fields.op() != BagOp::kConnection || !fields.number("conn", id)) return false;
  const BagFields about(record.data);
  connections.emplace(
      id, BagConnection{id, std::string(fields.get("topic")), std::string(about.get("type")),
                        std::string(about.get("md5sum"))});
  return true;
}

void count(Connections connections, BagContents& contents) {
  for (const BagChunk& chunk : contents.chunks) {
    for (const ChunkShare& share : chunk.shares) {
      const auto found = connections.find(share.connection);
      if (found == connections.end()) continue;
      found->second.messages += share.messages;
      contents.begin = std::min(contents.begin, share.begin);
      contents.end = std::max(contents.end, share.end);
    }
  }
  for (auto& [id, connection] : connections) {
    if (connection.messages > 0) contents.connections.push_back(std::move(connection));
  }
}

/// Reads the records of the index; a record that does not fit ends the reading.
class IndexReader {
 public:
  explicit IndexReader(const std::string& path) : file_(path) {}

  BagContents read(const std::function<void(std::uint32_t, const ros::Time&)>& on_entry) {
    BagContents contents;
    const BagFields fields = take(BagOp::kBagHeader);
    std::uint32_t connection_count = 0;
    std::uint32_t chunk_count = 0;
    require(fields.number("index_pos", contents.end_of_chunks) &&
            fields.number("conn_count", connection_count) &&
            fields.number("chunk_count", chunk_count));
    if (contents.end_of_chunks == 0) throw std::runtime_error("the index is missing");
    if (!file_.seek(contents.end_of_chunks)) throw std::runtime_error("the index is cut off");
    Connections connections;
    for (std::uint32_t i = 0; i < connection_count; ++i) {
      take(BagOp::kConnection);
      require(takeConnection({header_, data_}, connections));
    }
    std::vector<std::uint32_t> shares;  // by chunk
    for (std::uint32_t i = 0; i < chunk_count; ++i) {
      const BagFields info = take(BagOp::kChunkInfo);
      contents.chunks.emplace_back();
      shares.push_back(0);
      require(info.number("chunk_pos", contents.chunks.back().position) &&
              info.number("count", shares.back()));
    }
    for (std::uint32_t i = 0; i < chunk_count; ++i) {
      readChunk(contents.chunks[i], shares[i], on_entry);
    }
    count(std::move(connections), contents);
    return contents;
  }

 private:
  // The time range in the chunk's info also covers unused topics, and some writers get it wrong.
  // The range of its index records is exact.
  void readChunk(BagChunk& chunk, std::uint32_t shares,
                 const std::function<void(std::uint32_t, const ros::Time&)>& on_entry) {
    require(file_.seek(chunk.position) && file_.takeHeader(header_, length_) &&
            BagFields(header_).op() == BagOp::kChunk && file_.skip(length_));
    for (std::uint32_t i = 0; i < shares; ++i) {
      constexpr std::size_t kEntry = 12;  // time, place in the chunk
      std::uint32_t connection = 0;
      const BagFields fields = take(BagOp::kIndexData);
      require(fields.number("conn", connection) && data_.size() % kEntry == 0);
      ChunkShare& share = chunk.shareOf(connection);
      for (std::size_t at = 0; at < data_.size(); at += kEntry) {
        const ros::Time time = bagTime(&data_[at]);
        share.add(time);
        if (on_entry) on_entry(connection, time);
      }
    }
  }

  BagFields take(BagOp op) {
    require(file_.takeHeader(header_, length_) && BagFields(header_).op() == op &&
            file_.take(length_, data_));
    return BagFields(header_);
  }
  void require(bool fits) const {
    if (fits) return;
    throw std::runtime_error("the index does not fit the file at byte " +
                             std::to_string(file_.position()));
  }

  BagRecordFile file_;
  std::string header_;
  std::string data_;
  std::uint32_t length_ = 0;
};

}  // namespace

void ChunkShare::add(const ros::Time& time) {
  ++messages;
  begin = std::min(begin, time);
  end = std::max(end, time);
}

ChunkShare& BagChunk::shareOf(std::uint32_t connection) {
  const auto found = std::find_if(
      shares.begin(), shares.end(),
      [connection](const ChunkShare& share) { return share.connection == connection; });
  if (found != shares.end()) return *found;
  shares.emplace_back();
  shares.back().connection = connection;
  return shares.back();
}

std::uint64_t BagContents::messages() const {
  std::uint64_t sum = 0;
  for (const BagConnection& connection : connections) sum += connection.messages;
  return sum;
}

void BagLoss::add(std::uint64_t where, std::uint64_t count) {
  if (bytes == 0) first = where;
  bytes += count;
}

BagContents contentsByIndex(const std::string& path,
                            const std::function<void(std::uint32_t, const ros::Time&)>& on_entry) {
  return IndexReader(path).read(on_entry);
}

BagScan contentsByScan(const std::string& path) {
  BagRecordFile file(path);
  BagScan result;
  result.contents.end_of_chunks = file.size();
  Connections connections;
  std::string header;
  std::string packed;
  std::string chunk;
  while (file.rest() > 0) {
    const std::uint64_t begin = file.position();
    std::uint32_t length = 0;
    // Each record contains its type.
    if (!file.takeHeader(header, length) || length > file.rest() ||
        BagFields(header).op() == BagOp::kNone) {
      file.seekChunk(begin + 1);
      result.loss.add(begin, file.position() - begin);
      continue;
    }
    if (BagFields(header).op() != BagOp::kChunk) {
      if (BagFields(header).op() == BagOp::kConnection && file.take(length, packed)) {
        takeConnection({header, packed}, connections);
      } else {
        file.skip(length);
      }
      continue;
    }
    const ChunkState state = takeChunk(file, header, length, packed, chunk);
    if (state == ChunkState::kNoHeader) file.seekChunk(begin + 16);
    if (state != ChunkState::kWhole) {
      result.loss.add(begin, file.position() - begin);
      continue;
    }
    BagChunk found;
    found.position = begin;
    std::string_view rest = chunk;
    BagRecord record;
    ChunkMessage message;
    while (takeRecord(rest, record)) {
      if (asMessage(record, message)) {
        found.shareOf(message.connection).add(message.time);
      } else {
        takeConnection(record, connections);
      }
    }
    if (!rest.empty()) result.loss.add(begin, rest.size());
    result.contents.chunks.push_back(std::move(found));
  }
  count(std::move(connections), result.contents);
  return result;
}

std::string bagEncryptor(const std::string& path) {
  try {
    BagRecordFile file(path);
    std::string header;
    std::uint32_t data_length = 0;
    if (!file.takeHeader(header, data_length)) return "";
    return std::string(BagFields(header).get("encryptor"));
  } catch (const std::runtime_error&) {
    return "";  // its faults are reported elsewhere
  }
}

}  // namespace ring_gyro::bridge
