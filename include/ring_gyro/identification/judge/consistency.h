#pragma once

#include <cstdint>
#include <string>

namespace cvg {

/// Bounds of the mean normalised innovation squared in 95 % of the runs of a consistent filter. Its
/// expected value is the number of measured values per update.
struct NisBounds {
  double lower = 0.0;
  double upper = 0.0;
};
NisBounds nisBounds(std::uint64_t updates, int degrees_of_freedom = 2);

/// If a mean normalised innovation squared is above its upper bound times this, the data do not
/// follow the model, and the sigmas are not those of the parameters.
constexpr double kHopelessNis = 10.0;

/// Normalised innovations squared of a filter: of all updates, and of those since the filter has
/// converged (or settled), which its first guesses no longer affect.
struct NisTally {
  std::uint64_t updates = 0;
  double sum = 0.0;
  std::uint64_t updates_converged = 0;
  double sum_converged = 0.0;

  /// `converged`: whether the filter had converged before this update.
  void add(double normalised_innovation_squared, bool converged);
  /// The filter is no longer converged: counts again from the start.
  void startAnew() {
    updates_converged = 0;
    sum_converged = 0.0;
  }
  /// Why an estimate does not fit its data: one line with the remedy, empty if it fits. Judged by
  /// the updates since convergence, or by all if there are none.
  std::string misfit(int degrees_of_freedom = 2) const;
};

}  // namespace cvg
