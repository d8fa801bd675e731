#pragma once

#include <cstdint>
#include <string>

namespace cvg {

/// Where a mean normalised innovation squared lies in 95 % of runs of a consistent filter, whose
/// expected value is the degrees of freedom of one.
struct NisBounds {
  double lower = 0.0;
  double upper = 0.0;
};
NisBounds nisBounds(std::uint64_t updates, int degrees_of_freedom = 2);

/// A mean normalised innovation squared beyond this many times its upper bound says that the data
/// are not of the model: whatever the sigmas are, they are not those of the parameters.
constexpr double kHopelessNis = 10.0;

/// Normalised innovations squared of the updates of a filter, of all and of those that count: since
/// it has converged (or settled), when its first guesses are over.
struct NisTally {
  std::uint64_t updates = 0;
  double sum = 0.0;
  std::uint64_t updates_converged = 0;
  double sum_converged = 0.0;

  /// `converged`: before this update.
  void add(double normalised_innovation_squared, bool converged);
  /// It has not converged after all.
  void startAnew() {
    updates_converged = 0;
    sum_converged = 0.0;
  }
  /// Why an estimate does not fit its data, by the updates since it converged, or by all without
  /// any; one line with the mend; empty: it may.
  std::string misfit(int degrees_of_freedom = 2) const;
};

}  // namespace cvg
