#pragma once

#include <string>
#include <vector>

#include "ring_gyro/analysis/run_record.h"
#include "ring_gyro/analysis/run_summary.h"

namespace ring_gyro::tools {

/// The summary as printed tables, in degrees, with the sensed rate, which is minus the pattern's.
std::string summaryText(const cvg::RunRecord& record, const cvg::RunSummary& summary);

/// The same for programs, in SI units; unknown values are null.
std::string summaryJson(const cvg::RunRecord& record, const cvg::RunSummary& summary);

/// The files that writeSeries writes; empty for an empty name.
std::vector<std::string> seriesFiles(const std::string& directory);

/// Makes the folder for these files if it is missing. Throws std::runtime_error with the line of
/// writeFault.
void makeSeriesFolder(const std::string& directory);

/// Writes series for plots, thinned to what a plot can show, to files in `directory`, which must
/// exist: loops.csv, ring_up.csv, gains.csv, estimates.csv, rates.csv, allan.csv. Throws
/// std::runtime_error.
void writeSeries(const cvg::RunRecord& record, const cvg::RunSummary& summary,
                 const std::string& directory);

}  // namespace ring_gyro::tools
