#pragma once

#include <optional>
#include <string>

#include "ring_gyro/common/parameter_table.h"

namespace cvg {

/// As parseNumber(), with YAML's .nan and .inf.
std::optional<double> numberFromText(const std::string& text);

/// Why `text` cannot be the value of `parameter`, empty when it can and has been stored.
std::string storeText(const Parameter& parameter, const std::string& text);

/// What a value may be, as a person reads it: "[0, 1] [rad/s]", "one of: a, b".
std::string allowedText(const Parameter& parameter);

/// Present value of the target, as the configuration file would have it.
std::string valueText(const Parameter& parameter);

}  // namespace cvg
