#pragma once

#include <optional>
#include <string>

#include "ring_gyro/common/parameter_table.h"

namespace cvg {

/// Like parseNumber(), and also accepts YAML's .nan and .inf.
std::optional<double> numberFromText(const std::string& text);

/// Stores `text` as the value of `parameter`. Gives the reason if that is not possible; empty if it
/// was stored.
std::string storeText(const Parameter& parameter, const std::string& text);

/// The allowed values as printed text: "[0, 1] [rad/s]", "one of: a, b".
std::string allowedText(const Parameter& parameter);

/// Present value of the target, in the form of the configuration file.
std::string valueText(const Parameter& parameter);

}  // namespace cvg
