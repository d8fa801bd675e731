#include "ring_gyro/logs/log_error.h"

#include <algorithm>

namespace cvg {
namespace {

/// Names in a damaged file can contain any byte: control characters are shown as '?'.
std::string oneLine(std::string text) {
  std::replace_if(
      text.begin(), text.end(),
      [](char each) { return static_cast<unsigned char>(each) < 0x20 || each == 0x7f; }, '?');
  return text;
}

}  // namespace

LogError::LogError(const std::string& file, const std::string& place, const std::string& fault,
                   const std::string& mend)
    : std::runtime_error(oneLine(file + (place.empty() ? "" : ", " + place) + ": " + fault +
                                 (mend.empty() ? "" : "; " + mend))) {}

const char* toString(RowFault fault) {
  switch (fault) {
    case RowFault::kRagged:
      return "with another number of fields";
    case RowFault::kNotANumber:
      return "with something that is no number";
    case RowFault::kNotFinite:
      return "with NaN or infinity";
    case RowFault::kOutOfRange:
      return "with a value out of range";
    case RowFault::kTime:
      return "whose time does not follow";
    case RowFault::kCount:
      break;
  }
  return "";
}

}  // namespace cvg
