#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "ring_gyro/logs/log_error.h"
#include "ring_gyro/logs/mat_structure.h"

namespace cvg {
namespace {

using Count = std::uint64_t;

constexpr std::size_t kHeader = 128;
constexpr int kDeepest = 64;              // nesting of arrays in cells and structs
constexpr Count kLongestHead = 4096;      // of a name (MATLAB: 63 at most) or dimensions [bytes]
constexpr std::size_t kChunk = 1U << 14;  // bytes at a time
constexpr char kMend[] = "the file is damaged or not whole: copy or save it again";

// Types of elements and classes of arrays, from MathWorks' description of the format.
enum Type : std::uint32_t { kInt8 = 1, kInt32 = 5, kUint32 = 6, kMatrix = 14, kCompressed = 15 };
enum Class : std::uint32_t {
  kCell = 1,
  kStruct = 2,
  kObject = 3,
  kChar = 4,
  kFirstNumber = 6,
  kLastNumber = 15,
  kOpaque = 17
};

/// Bytes of one number in an element of this type; 0: not a type of numbers.
Count sizeOf(std::uint32_t type) {
  constexpr std::array<std::uint8_t, 19> kSizes = {0, 1, 1, 2, 2, 4, 4, 4, 0, 8,
                                                   0, 0, 8, 8, 0, 0, 1, 2, 4};
  return type < kSizes.size() ? kSizes[type] : 0;
}

struct Damage {
  std::string what;
};

/// A stream of bytes, from the file or inflated from it. Both kinds throw Damage at their end.
struct Bytes {
  std::function<void(char*, std::size_t)> read;
  std::function<void(Count)> skip;
};

/// The part of a file that has not been read yet.
class FileBytes {
 public:
  explicit FileBytes(const std::string& path) : file_(std::fopen(path.c_str(), "rb"), std::fclose) {
    if (!file_ || ::fseeko(file_.get(), 0, SEEK_END) != 0) throw Damage{"cannot be read"};
    left_ = static_cast<Count>(::ftello(file_.get()));
    std::rewind(file_.get());
  }

  Count left() const { return left_; }
  void read(char* to, std::size_t count) {
    require(count);
    if (std::fread(to, 1, count, file_.get()) != count) throw Damage{"cannot be read"};
    left_ -= count;
  }
  void skip(Count count) {
    require(count);
    if (::fseeko(file_.get(), static_cast<off_t>(count), SEEK_CUR) != 0) {
      throw Damage{"cannot be read"};
    }
    left_ -= count;
  }

 private:
  void require(Count count) const {
    if (count <= left_) return;
    throw Damage{"is cut: " + std::to_string(count) + " bytes are to follow, the file has " +
                 std::to_string(left_)};
  }

  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;
  Count left_ = 0;
};

/// The next bytes of a file, inflated.
class InflatedBytes {
 public:
  InflatedBytes(FileBytes& file, Count packed) : file_(file), packed_(packed), buffer_(kChunk) {
    if (inflateInit(&stream_) != Z_OK) throw Damage{"cannot be inflated: no memory"};
  }
  ~InflatedBytes() { inflateEnd(&stream_); }
  InflatedBytes(const InflatedBytes&) = delete;
  InflatedBytes& operator=(const InflatedBytes&) = delete;

  void read(char* to, std::size_t count) {
    if (inflateTo(to, count) < count) throw Damage{"holds less than it claims"};
  }
  void skip(Count count) {
    std::array<char, kChunk> unused;
    while (count > 0) {
      const std::size_t part = std::min<Count>(count, unused.size());
      read(unused.data(), part);
      count -= part;
    }
  }
  /// The rest, with its checksum.
  void finish() {
    std::array<char, kChunk> unused;
    while (!ended_) inflateTo(unused.data(), unused.size());
    file_.skip(packed_);
  }

 private:
  std::size_t inflateTo(char* to, std::size_t count) {
    stream_.next_out = reinterpret_cast<Bytef*>(to);
    stream_.avail_out = static_cast<uInt>(count);
    while (stream_.avail_out > 0 && !ended_) {
      if (stream_.avail_in == 0) fill();
      const int code = inflate(&stream_, Z_NO_FLUSH);
      ended_ = code == Z_STREAM_END;
      if (code != Z_OK && !ended_) throw Damage{"has damaged compressed data"};
    }
    return count - stream_.avail_out;
  }
  void fill() {
    const std::size_t count = std::min({packed_, file_.left(), Count{buffer_.size()}});
    if (count == 0) throw Damage{"is cut in its compressed data"};
    file_.read(buffer_.data(), count);
    packed_ -= count;
    stream_.next_in = reinterpret_cast<Bytef*>(buffer_.data());
    stream_.avail_in = static_cast<uInt>(count);
  }

  FileBytes& file_;
  Count packed_;  // not yet read from the file
  std::vector<char> buffer_;
  z_stream stream_{};
  bool ended_ = false;
};

struct Element {
  std::uint32_t type = 0;
  Count size = 0;     // of its data
  Count padding = 0;  // after its data
};

Damage claims(Count count, const std::string& what, Count held) {
  return {"claims " + std::to_string(count) + " " + what + " and holds " + std::to_string(held)};
}

Count product(Count a, Count b) {
  Count result = 0;
  if (__builtin_mul_overflow(a, b, &result)) {
    throw Damage{"claims dimensions whose product nothing can count"};
  }
  return result;
}

/// One variable with all its contents.
class Variable {
 public:
  Variable(Bytes bytes, bool swapped) : bytes_(std::move(bytes)), swapped_(swapped) {}

  /// The name, as far as it has been read.
  const std::string& name() const { return name_; }

  /// Reads the next tag, of an element within `left` bytes, and subtracts the tag from `left`.
  Element next(Count& left) {
    if (left < 8) throw Damage{"holds less than it claims"};
    Element element;
    const std::uint32_t first = word();
    const bool small = (first >> 16) != 0;  // size and type in one word, the data in the other
    element.type = small ? first & 0xffff : first;
    element.size = small ? first >> 16 : word();
    left -= small ? 4 : 8;
    if (element.size > (small ? 4 : left)) throw Damage{"holds less than it claims"};
    left -= element.size;
    // Compressed data have no padding, and some writers omit the last padding.
    const Count unit = small ? 4 : 8;
    const Count padding = (unit - element.size % unit) % unit;
    element.padding = element.type == kCompressed ? 0 : std::min(left, padding);
    left -= element.padding;
    return element;
  }

  /// Checks the next array, of `left` bytes after its tag.
  void checkArray(Count left, int depth = 0) {
    if (left == 0) return;  // an empty cell or field
    if (depth > kDeepest) throw Damage{"has arrays in arrays, over 64 deep"};
    const std::uint32_t flags = words(left, kUint32).at(0);
    const std::uint32_t kind = flags & 0xff;
    if (kind == kOpaque) return bytes_.skip(left);
    const std::vector<std::uint32_t> dimensions = words(left, kInt32);
    const std::string name = text(left);
    if (depth == 0) name_ = name;
    Count count = 1;
    for (const std::uint32_t dimension : dimensions) {
      if (dimension > 0x7fffffff) throw Damage{"claims a negative dimension"};
      count = product(count, dimension);
    }
    if (kFirstNumber <= kind && kind <= kLastNumber) {
      const bool is_complex = (flags & 0x800) != 0;
      for (int part = 0; part < (is_complex ? 2 : 1); ++part) checkNumbers(left, count);
    } else if (kind == kChar && left > 0) {
      const Element data = next(left);
      // Some writers omit the data of a short text.
      if (count > std::max(data.size, kLongestHead)) throw claims(count, "characters", data.size);
      skip(data);
    } else if (kind == kCell) {
      checkArrays(left, count, depth);
    } else if (kind == kStruct || kind == kObject) {
      if (kind == kObject) text(left);  // name of the class
      const Count length = words(left, kInt32).at(0);
      const Element names = next(left);
      skip(names);
      checkArrays(left, product(count, length == 0 ? 0 : names.size / length), depth);
    }
    while (left >= 8) {  // sparse arrays, function handles
      const Element rest = next(left);
      if (rest.type == kMatrix) {
        checkArray(rest.size, depth + 1);
        bytes_.skip(rest.padding);
      } else {
        skip(rest);
      }
    }
    bytes_.skip(left);
  }

 private:
  std::uint32_t word() {
    std::array<char, 4> raw;
    bytes_.read(raw.data(), raw.size());
    std::uint32_t value = 0;
    for (std::size_t k = 0; k < raw.size(); ++k) {
      const std::uint32_t byte = static_cast<unsigned char>(raw[k]);
      value |= byte << (8 * (swapped_ ? raw.size() - 1 - k : k));
    }
    return value;
  }

  void skip(const Element& element) { bytes_.skip(element.size + element.padding); }

  std::vector<std::uint32_t> words(Count& left, Type type) {
    const Element element = next(left);
    if (element.type != type || element.size < 4 || element.size > kLongestHead) {
      throw Damage{"has a damaged head"};
    }
    std::vector<std::uint32_t> values(element.size / 4);
    for (std::uint32_t& value : values) value = word();
    bytes_.skip(element.size % 4 + element.padding);
    return values;
  }

  std::string text(Count& left) {
    const Element element = next(left);
    if (element.type != kInt8 || element.size > kLongestHead) throw Damage{"has a damaged head"};
    std::string characters(element.size, '\0');
    bytes_.read(characters.data(), characters.size());
    bytes_.skip(element.padding);
    return characters;
  }

  void checkNumbers(Count& left, Count count) {
    if (count == 0 && left == 0) return;
    const Element data = next(left);
    const Count size = sizeOf(data.type);
    if (size == 0) throw Damage{"has data of no known type"};
    if (data.size != product(count, size)) throw claims(count, "numbers", data.size / size);
    skip(data);
  }

  void checkArrays(Count& left, Count count, int depth) {
    if (count > left / 8) throw claims(count, "arrays", left / 8);  // each has a tag
    for (Count k = 0; k < count; ++k) {
      const Element array = next(left);
      if (array.type != kMatrix) throw Damage{"has something that is no array within it"};
      checkArray(array.size, depth + 1);
      bytes_.skip(array.padding);
    }
  }

  Bytes bytes_;
  bool swapped_;
  std::string name_;
};

template <typename Source>
Bytes bytesOf(Source& source) {
  return {[&source](char* to, std::size_t count) { source.read(to, count); },
          [&source](Count count) { source.skip(count); }};
}

/// Checks the next variable in the file; `name`: as far as it could be read.
void checkNext(FileBytes& file, bool swapped, std::string& name) {
  Variable plain(bytesOf(file), swapped);
  Count unlimited = ~Count{0};  // reading its data will show whether it ends within the file
  const Element element = plain.next(unlimited);
  const auto check = [&name](Variable& variable, Count size) {
    try {
      variable.checkArray(size);
    } catch (const Damage&) {
      name = variable.name();
      throw;
    }
    name = variable.name();
  };
  if (element.type == kMatrix) {
    check(plain, element.size);
    file.skip(std::min(element.padding, file.left()));
  } else if (element.type == kCompressed) {
    InflatedBytes inflated(file, element.size);
    Variable packed(bytesOf(inflated), swapped);
    Count inner = ~Count{0};
    const Element array = packed.next(inner);
    if (array.type == kMatrix) check(packed, array.size);
    inflated.finish();
  } else {
    file.skip(element.size + element.padding);
  }
}

}  // namespace

void requireWholeMat5(const std::string& path) {
  std::uint64_t number = 0;
  std::string name;
  try {
    FileBytes file(path);
    std::array<char, kHeader> header;
    file.read(header.data(), header.size());
    const bool swapped = header[126] == 'M';
    while (file.left() > 0) {
      ++number;
      name.clear();
      checkNext(file, swapped, name);
    }
  } catch (const Damage& damage) {
    std::string place = number == 0 ? "" : "variable " + std::to_string(number);
    if (!name.empty()) place = "variable " + name;
    throw LogError(path, place, damage.what, kMend);
  }
}

}  // namespace cvg
