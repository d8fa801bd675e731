#include "ring_gyro/logs/column_map.h"

#include <algorithm>
#include <boost/algorithm/string/trim.hpp>
#include <cmath>
#include <iomanip>
#include <limits>
#include <sstream>
#include <stdexcept>

#include "ring_gyro/common/angle.h"
#include "ring_gyro/common/number_text.h"
#include "ring_gyro/logs/log_error.h"

namespace cvg {
namespace {

constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

std::string trimmed(const std::string& text) { return boost::algorithm::trim_copy(text); }

/// "theta" and the rest of "theta=...".
std::pair<Quantity, std::string> splitSpecification(const std::string& option,
                                                    const std::string& specification) {
  const std::size_t equals = specification.find('=');
  const std::string name = trimmed(specification.substr(0, equals));
  const std::optional<Quantity> quantity = quantityFromName(name);
  if (equals == std::string::npos || !quantity) {
    std::string known;
    for (const QuantityInfo& info : quantities()) {
      known += (known.empty() ? "" : ", ") + std::string(info.name);
    }
    throw std::invalid_argument(
        option + " " + specification +
        (equals == std::string::npos ? " has no '='" : ": " + name + " is no quantity") +
        "; the quantities are " + known);
  }
  return {*quantity, trimmed(specification.substr(equals + 1))};
}

/// Default unit of a frequency: rad/s if the name begins with omega, otherwise Hz.
std::string unsaidUnit(Quantity quantity, const std::string& name) {
  if (quantity != Quantity::kOmega) return "";
  const std::string lower = boost::algorithm::trim_copy(name);
  const bool is_omega =
      !lower.empty() && (lower[0] == 'o' || lower[0] == 'O' || lower[0] == 'w' || lower[0] == 'W');
  return is_omega ? "" : "Hz";
}

std::string valueText(const QuantityInfo& info, double value) {
  if (!std::isfinite(value)) return "-";
  std::ostringstream out;
  out << std::setprecision(6) << value;
  if (info.dimension == Dimension::kNone) return out.str();
  out << ' ' << siUnit(info.dimension);
  if (info.quantity == Quantity::kOmega) out << " = " << value / kTwoPi << " Hz";
  if (info.quantity == Quantity::kVirtualRate) out << " = " << toDegrees(value) << " deg/s";
  if (info.dimension == Dimension::kAngle) out << " = " << toDegrees(value) << " deg";
  return out.str();
}

}  // namespace

std::pair<std::string, std::string> splitHeader(const std::string& header) {
  const std::string text = trimmed(header);
  for (const auto& [open, close] : {std::pair('[', ']'), std::pair('(', ')')}) {
    const std::size_t begin = text.rfind(open);
    if (begin == std::string::npos || begin == 0 || text.back() != close) continue;
    const std::string unit = trimmed(text.substr(begin + 1, text.size() - begin - 2));
    if (isUnit(unit)) return {trimmed(text.substr(0, begin)), unit};
  }
  // "U / mV", "omega_rad_s", "theta_deg", "theta deg".
  if (const std::size_t slash = text.find('/'); slash != std::string::npos && slash > 0) {
    const std::string unit = trimmed(text.substr(slash + 1));
    if (isUnit(unit)) return {trimmed(text.substr(0, slash)), unit};
  }
  const std::size_t last = text.find_last_of("_ .-");
  if (last == std::string::npos || last == 0) return {text, ""};
  const std::string unit = text.substr(last + 1);
  const std::size_t before = text.find_last_of("_ .-", last - 1);
  if (before != std::string::npos && before > 0) {
    const std::string rate = text.substr(before + 1, last - before - 1) + "/" + unit;
    if (isUnit(rate)) return {text.substr(0, before), rate};
  }
  if (isUnit(unit)) return {text.substr(0, last), unit};
  return {text, ""};
}

ColumnMap::ColumnMap(std::string file, std::vector<std::string> names,
                     const std::vector<std::string>& columns,
                     const std::vector<std::string>& constants,
                     const std::vector<std::string>& ignored)
    : file_(std::move(file)), names_(std::move(names)) {
  for (const std::string& specification : columns) give(specification);
  for (const std::string& specification : constants) giveConstant(specification);
  guess(ignored);
  chooseMotion();
}

void ColumnMap::fail(const std::string& fault, const std::string& mend) const {
  throw LogError(file_, "", fault, mend);
}

std::size_t ColumnMap::columnNamed(const std::string& name) const {
  const auto same = std::find_if(names_.begin(), names_.end(),
                                 [&](const std::string& known) { return trimmed(known) == name; });
  if (same != names_.end()) return static_cast<std::size_t>(same - names_.begin());
  // "Angle" means "Angle [deg]" if that is unique.
  std::size_t found = kNone;
  for (std::size_t k = 0; k < names_.size(); ++k) {
    if (splitHeader(names_[k]).first != name) continue;
    if (found != kNone) return kNone;
    found = k;
  }
  if (found != kNone) return found;
  if (name.empty() || name.size() > 6 ||
      name.find_first_not_of("0123456789") != std::string::npos) {
    return kNone;
  }
  const unsigned long number = std::stoul(name);
  return number >= 1 && number <= names_.size() ? number - 1 : kNone;
}

void ColumnMap::give(const std::string& specification) {
  const auto [quantity, text] = splitSpecification("--column", specification);
  const QuantityInfo& info = infoOf(quantity);
  if (has(quantity)) fail(std::string(info.name) + " is given twice", "say it once");
  ColumnUse use;
  use.given = true;
  std::string name = text;
  std::string unit;
  std::size_t column = columnNamed(name);
  if (column == kNone && !name.empty() && name[0] == '-') {
    use.scale = -1.0;
    name = trimmed(name.substr(1));
    column = columnNamed(name);
  }
  if (const std::size_t colon = name.rfind(':'); column == kNone && colon != std::string::npos) {
    unit = trimmed(name.substr(colon + 1));
    name = trimmed(name.substr(0, colon));
    column = columnNamed(name);
  }
  if (column == kNone) {
    std::string known;
    for (const std::string& each : names_) known += (known.empty() ? "" : ", ") + each;
    fail("has no column " + name, "its columns are " + known + " (or a number from 1)");
  }
  // Without a given unit, use the one in the header.
  if (unit.empty()) {
    unit = splitHeader(names_[column]).second;
    if (!unit.empty() && guessQuantity(names_[column])) unit.clear();  // part of a name, not a unit
    if (!unit.empty() && !unitScale(unit, info.dimension)) {
      fail("column " + names_[column] + " is said to be " + info.name + ", but " + unit +
               " is no unit of it",
           "say --column " + std::string(info.name) + "=" + name + ":UNIT with one of " +
               knownUnits(info.dimension));
    }
    if (unit.empty()) unit = unsaidUnit(quantity, name);
  }
  if (!unit.empty()) {
    const std::optional<double> scale = unitScale(unit, info.dimension);
    if (!scale) {
      fail(unit + " is no unit of " + info.name + " (" + info.meaning + ")",
           "say one of " + knownUnits(info.dimension) + ", or a factor to " +
               siUnit(info.dimension));
    }
    use.scale *= *scale;
    use.unit = unit;
  }
  use.column = column;
  uses_[indexOf(quantity)] = use;
}

void ColumnMap::giveConstant(const std::string& specification) {
  const auto [quantity, text] = splitSpecification("--constant", specification);
  const QuantityInfo& info = infoOf(quantity);
  if (has(quantity)) fail(std::string(info.name) + " is given twice", "say it once");
  ColumnUse use;
  use.given = true;
  use.constant = quantityFromText("--constant " + std::string(info.name), text, info.dimension);
  uses_[indexOf(quantity)] = use;
}

void ColumnMap::guess(const std::vector<std::string>& ignored) {
  std::vector<bool> taken(names_.size(), false);
  std::vector<Quantity> not_guessed;
  for (const std::string& name : ignored) {
    const std::optional<Quantity> quantity = quantityFromName(name);
    const std::size_t column = columnNamed(name);
    if (!quantity && column == kNone) fail("has no column " + name + " to ignore", "leave it out");
    if (quantity) not_guessed.push_back(*quantity);
    if (column != kNone) taken[column] = true;
  }
  for (const auto& use : uses_) {
    if (use && use->column) taken[*use->column] = true;
  }
  for (std::size_t k = 0; k < names_.size(); ++k) {
    if (taken[k]) continue;
    ColumnUse use;
    use.column = k;
    std::optional<Quantity> quantity = guessQuantity(names_[k]);
    std::string name = names_[k];
    if (!quantity) {
      std::tie(name, use.unit) = splitHeader(names_[k]);
      quantity = guessQuantity(name);
      const bool fits =
          quantity && unitScale(use.unit.empty() ? "1" : use.unit, infoOf(*quantity).dimension);
      // "sustain [V]" is not the gain.
      if (!fits && unitScale(use.unit, Dimension::kVoltage))
        quantity = guessQuantity(name + "volts");
    }
    if (!quantity || has(*quantity)) continue;
    if (std::count(not_guessed.begin(), not_guessed.end(), *quantity) > 0) continue;
    if (use.unit.empty()) use.unit = unsaidUnit(*quantity, name);
    if (!use.unit.empty()) {
      const std::optional<double> scale = unitScale(use.unit, infoOf(*quantity).dimension);
      if (!scale) continue;  // another unit means another quantity
      use.scale = *scale;
    }
    uses_[indexOf(*quantity)] = use;
  }
  // A table without names, in the order of the simplest form.
  const bool nameless =
      !names_.empty() && names_.front() == "1" && names_.back() == std::to_string(names_.size());
  if (nameless && (names_.size() == 8 || names_.size() == 9)) {
    for (std::size_t k = 0; k < names_.size(); ++k) {
      if (uses_[k] || taken[k]) continue;
      uses_[k] = ColumnUse{};
      uses_[k]->column = k;
    }
  }
}

void ColumnMap::chooseMotion() {
  const auto all = [this](std::initializer_list<Quantity> list) {
    return std::all_of(list.begin(), list.end(), [this](Quantity q) { return has(q); });
  };
  const auto said = [this](std::initializer_list<Quantity> list) {
    return std::any_of(list.begin(), list.end(),
                       [this](Quantity q) { return has(q) && use(q)->given; });
  };
  using Q = Quantity;
  if (said({Q::kA, Q::kB, Q::kTheta})) {
    motion_ = Motion::kElements;
  } else if (said({Q::kCx, Q::kSx, Q::kCy, Q::kSy})) {
    motion_ = Motion::kEnvelope;
  } else if (said({Q::kX, Q::kY})) {
    motion_ = Motion::kSamples;
  } else if (all({Q::kA, Q::kB, Q::kTheta})) {
    motion_ = Motion::kElements;
  } else if (all({Q::kCx, Q::kSx, Q::kCy, Q::kSy})) {
    motion_ = Motion::kEnvelope;
  } else if (all({Q::kX, Q::kY})) {
    motion_ = Motion::kSamples;
  }
  // Quantities of another form of the motion are not used.
  const auto drop = [this](std::initializer_list<Quantity> list) {
    for (const Quantity quantity : list) uses_[indexOf(quantity)].reset();
  };
  if (motion_ != Motion::kElements) drop({Q::kA, Q::kB, Q::kTheta, Q::kPhi});
  if (motion_ != Motion::kEnvelope) drop({Q::kCx, Q::kSx, Q::kCy, Q::kSy});
  if (motion_ != Motion::kSamples) drop({Q::kX, Q::kY});
}

void ColumnMap::requireComplete(bool sampled) const {
  using Q = Quantity;
  std::string missing;
  const auto need = [&](Quantity quantity) {
    if (has(quantity)) return;
    const QuantityInfo& info = infoOf(quantity);
    missing += (missing.empty() ? "" : ", ") + std::string(info.name) + " (" + info.meaning + ")";
    for (const std::string& header : names_) {
      const auto [name, unit] = splitHeader(header);
      if (guessQuantity(name) == quantity && !unit.empty() && !unitScale(unit, info.dimension)) {
        missing += " [column " + header + " has another unit]";
      }
    }
  };
  if (!sampled) need(Q::kTime);
  switch (motion_) {
    case Motion::kElements:
      for (const Quantity quantity : {Q::kA, Q::kB, Q::kTheta}) need(quantity);
      break;
    case Motion::kEnvelope:
      for (const Quantity quantity : {Q::kCx, Q::kSx, Q::kCy, Q::kSy}) need(quantity);
      break;
    case Motion::kSamples:
      for (const Quantity quantity : {Q::kX, Q::kY}) need(quantity);
      break;
  }
  need(Q::kOmega);
  const auto envelopes = {Q::kDriveXReal, Q::kDriveXImag, Q::kDriveYReal, Q::kDriveYImag};
  if (std::any_of(envelopes.begin(), envelopes.end(), [this](Q q) { return has(q); })) {
    for (const Quantity quantity : envelopes) need(quantity);
    if (motion_ == Motion::kSamples) need(Q::kReferencePhase);
  } else {
    if (!has(Q::kSustainVolts)) need(Q::kBeta);
    if (!has(Q::kQuadratureVolts)) need(Q::kAlpha);
  }
  if (missing.empty()) return;
  std::string known;
  for (const std::string& name : names_) known += (known.empty() ? "" : ", ") + name;
  fail("no column for " + missing,
       "say --column NAME=COLUMN:UNIT or --constant NAME=VALUE; the columns are " + known);
}

std::string ColumnMap::table(const std::vector<double>& first_row) const {
  std::vector<std::array<std::string, 5>> rows = {
      {"quantity", "column", "unit", "first value", "meaning"}};
  std::vector<bool> used(names_.size(), false);
  for (const QuantityInfo& info : quantities()) {
    const std::optional<ColumnUse>& each = use(info.quantity);
    if (!each) continue;
    std::string column = "(constant)";
    if (each->column) {
      used[*each->column] = true;
      column = (each->scale < 0.0 ? "-" : "") + names_[*each->column];
      if (!each->given) column += " (guess)";
    }
    const std::string unit = each->unit.empty() ? siUnit(info.dimension) : each->unit;
    rows.push_back({info.name, column, each->column ? unit : "",
                    valueText(info, first_row[indexOf(info.quantity)]), info.meaning});
  }
  if (motion_ == Motion::kElements && !has(Quantity::kPhi)) {
    rows.push_back({"phi", "(none)", "", "-90 deg", "taken as locked"});
  }
  std::array<std::size_t, 5> width{};
  for (const auto& row : rows) {
    for (std::size_t k = 0; k < row.size(); ++k) width[k] = std::max(width[k], row[k].size());
  }
  std::string text;
  for (const auto& row : rows) {
    std::string line = " ";
    for (std::size_t k = 0; k < row.size(); ++k) {
      line += " " + row[k];
      if (k + 1 < row.size()) line += std::string(width[k] - row[k].size() + 1, ' ');
    }
    text += line + "\n";
  }
  std::string rest;
  for (std::size_t k = 0; k < names_.size(); ++k) {
    if (!used[k]) rest += (rest.empty() ? "" : ", ") + names_[k];
  }
  if (!rest.empty()) text += "  not used: " + rest + "\n";
  return text;
}

}  // namespace cvg
