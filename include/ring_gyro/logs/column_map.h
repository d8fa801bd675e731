#pragma once

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "ring_gyro/logs/quantity.h"

namespace cvg {

/// Source of the values of a quantity: a column or a constant.
struct ColumnUse {
  std::optional<std::size_t> column;  ///< none: the constant
  double constant = 0.0;              ///< SI
  double scale = 1.0;                 ///< SI per unit of the column, with the sign
  std::string unit;                   ///< as given; empty: SI
  bool given = false;                 ///< true: given by the user; false: guessed
};

/// The quantity, unit and sign of each column.
///
/// The user's choices come first. The other columns are guessed from their names and the units in
/// the names ("Angle [deg]", "theta_deg", "U / mV"), each quantity at most once.
class ColumnMap {
 public:
  /// The motion is in elements a, b, theta; in Cx, Sx, Cy, Sy; or in samples x, y.
  enum class Motion { kElements, kEnvelope, kSamples };

  /// `columns`: each "theta=-Angle:deg", that is quantity = sign, name or number from 1, unit.
  /// `constants`: each "omega=14195Hz". `ignored`: columns or quantities that are not guessed.
  /// `file`: name for error messages.
  /// Throws LogError for an impossible choice, std::invalid_argument for text that cannot be
  /// parsed.
  ColumnMap(std::string file, std::vector<std::string> names,
            const std::vector<std::string>& columns, const std::vector<std::string>& constants = {},
            const std::vector<std::string>& ignored = {});

  bool has(Quantity quantity) const { return use(quantity).has_value(); }
  const std::optional<ColumnUse>& use(Quantity quantity) const { return uses_[indexOf(quantity)]; }
  Motion motion() const { return motion_; }
  bool hasDriveEnvelopes() const { return has(Quantity::kDriveXReal); }
  const std::string& file() const { return file_; }
  const std::vector<std::string>& names() const { return names_; }

  /// Throws LogError when a necessary quantity is missing. `sampled`: a sample rate replaces time.
  void requireComplete(bool sampled) const;

  /// Column, quantity, unit and value in SI of each quantity of this row; then the unused columns.
  std::string table(const std::vector<double>& first_row) const;

 private:
  void give(const std::string& specification);
  void giveConstant(const std::string& specification);
  void guess(const std::vector<std::string>& ignored);
  void chooseMotion();
  std::size_t columnNamed(const std::string& name) const;
  [[noreturn]] void fail(const std::string& fault, const std::string& mend) const;

  std::string file_;
  std::vector<std::string> names_;
  std::array<std::optional<ColumnUse>, kQuantityCount> uses_;
  Motion motion_ = Motion::kElements;
};

/// Name and unit of a header such as "Angle [deg]", "theta_deg", "U / mV", "a"; the unit may be
/// empty.
std::pair<std::string, std::string> splitHeader(const std::string& header);

}  // namespace cvg
