#pragma once

#include <stdexcept>
#include <string>

namespace cvg {

/// A log that cannot be used, in one line: file, place, what is wrong; the mend.
class LogError : public std::runtime_error {
 public:
  LogError(const std::string& file, const std::string& place, const std::string& fault,
           const std::string& mend);
};

/// What one row of a log can be wrong in.
enum class RowFault { kRagged, kNotANumber, kNotFinite, kOutOfRange, kTime, kCount };

const char* toString(RowFault fault);

/// One row that cannot be used; the rows after it can still be read.
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
