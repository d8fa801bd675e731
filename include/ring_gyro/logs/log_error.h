#pragma once

#include <stdexcept>
#include <string>

namespace cvg {

/// Error of an unusable log, in one line: file, place, fault; remedy.
class LogError : public std::runtime_error {
 public:
  LogError(const std::string& file, const std::string& place, const std::string& fault,
           const std::string& mend);
};

/// Possible faults of one row of a log.
enum class RowFault { kRagged, kNotANumber, kNotFinite, kOutOfRange, kTime, kCount };

const char* toString(RowFault fault);

/// Error of one unusable row; the rows after it can still be read.
class RowError : public LogError {
 public:
  RowError(RowFault kind, const std::string& file, const std::string& place,
           const std::string& fault, const std::string& mend)
      : LogError(file, place, fault, mend), kind_(kind) {}

  RowFault kind() const { return kind_; }

 private:
  RowFault kind_;
};

}  // namespace cvg
