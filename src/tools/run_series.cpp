#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <limits>
#include <stdexcept>
#include <vector>

#include "ring_gyro/analysis/allan_deviation.h"
#include "ring_gyro/common/angle.h"
#include "ring_gyro/common/formatted.h"
#include "ring_gyro/common/whole_file.h"
#include "ring_gyro/common/write_fault.h"
#include "run_report.h"

namespace ring_gyro::tools {
namespace {

constexpr std::size_t kMostRows = 4000;  // more than the pixel columns of a plot

/// Text of a CSV file: a line of names, then rows of numbers.
class Table {
 public:
  explicit Table(const char* names) : text_(std::string(names) + "\n") {}

  void row(std::initializer_list<double> values) {
    bool first = true;
    for (double value : values) {
      if (!first) text_ += ',';
      first = false;
      if (!std::isfinite(value)) continue;  // an empty cell
      text_ += cvg::formatted("%.10g", value);
    }
    text_ += '\n';
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

struct Extremes {
  double lowest = std::numeric_limits<double>::infinity();
  double highest = -std::numeric_limits<double>::infinity();
  void add(double value) {
    lowest = std::min(lowest, value);
    highest = std::max(highest, value);
  }
};

double phaseErrorInDegrees(const cvg::Orbit& orbit) {
  return cvg::toDegrees(orbit.phi + 0.5 * cvg::kPi);
}

std::size_t rowStep(std::size_t count) { return std::max<std::size_t>(1, count / kMostRows); }

// Extremes of each bin, so that thinning loses no excursion.
std::string loopsCsv(const cvg::RunRecord& record) {
  Table table(
      "time_s,theta_deg,a_V,beta_s,alpha,frequency_Hz,locked,"
      "phase_error_low_deg,phase_error_high_deg,b_over_a_low,b_over_a_high,"
      "true_phase_error_low_deg,true_phase_error_high_deg,true_b_over_a_low,true_b_over_a_high");
  const auto& blocks = record.blocks();
  const std::size_t step = rowStep(blocks.size());
  for (std::size_t first = 0; first < blocks.size(); first += step) {
    Extremes phase, quadrature, true_phase, true_quadrature;
    const cvg::RunBlock* measured = nullptr;
    for (std::size_t i = first; i < std::min(first + step, blocks.size()); ++i) {
      const cvg::RunBlock& block = blocks[i];
      if (block.has_elements && block.has_gains) {
        measured = &block;
        phase.add(phaseErrorInDegrees(block.measured));
        if (block.measured.a > 0.0) quadrature.add(block.measured.b / block.measured.a);
      }
      if (block.has_truth) {
        true_phase.add(phaseErrorInDegrees(block.truth));
        if (block.truth.a > 0.0) true_quadrature.add(block.truth.b / block.truth.a);
      }
    }
    if (!measured) continue;
    table.row({record.time(*measured), cvg::toDegrees(measured->measured.theta),
               measured->measured.a, measured->beta, measured->alpha,
               measured->reference_frequency / cvg::kTwoPi, measured->status.locked() ? 1.0 : 0.0,
               phase.lowest, phase.highest, quadrature.lowest, quadrature.highest,
               true_phase.lowest, true_phase.highest, true_quadrature.lowest,
               true_quadrature.highest});
  }
  return table.text();
}

// Every block until some time after the loops have locked.
std::string ringUpCsv(const cvg::RunRecord& record, const cvg::RunSummary& summary) {
  Table table("time_s,a_V,b_over_a,phase_error_deg,frequency_Hz,locked");
  const double end = summary.ring_up_time ? std::min(2.0 * *summary.ring_up_time, 4.0) : 4.0;
  for (const cvg::RunBlock& block : record.blocks()) {
    if (!block.has_elements || !block.has_gains) continue;
    if (record.time(block) > end) break;
    const cvg::Orbit& orbit = block.measured;
    table.row({record.time(block), orbit.a, orbit.a > 0.0 ? orbit.b / orbit.a : NAN,
               phaseErrorInDegrees(orbit), block.reference_frequency / cvg::kTwoPi,
               block.status.locked() ? 1.0 : 0.0});
  }
  return table.text();
}

std::string estimatesCsv(const cvg::RunRecord& record) {
  Table table(
      "time_s,gamma1,gamma2,mu1,mu2,ks,sigma_gamma1,sigma_gamma2,sigma_mu1,sigma_mu2,sigma_ks,"
      "residual_gamma1,residual_gamma2,normalised_innovation_squared,"
      "innovation_a_V,innovation_b_V,sigma_innovation_a_V,sigma_innovation_b_V,converged,"
      "angle_covered_deg");
  const auto& estimates = record.estimates();
  const std::size_t step = rowStep(estimates.size());
  for (std::size_t i = 0; i < estimates.size(); i += step) {
    const cvg::ParameterEstimate& e = estimates[i];
    if (!e.updated) continue;
    table.row({record.time(e.stamp.end_ns),
               e.value[cvg::kGamma1],
               e.value[cvg::kGamma2],
               e.value[cvg::kMu1],
               e.value[cvg::kMu2],
               e.value[cvg::kDriveGain],
               e.sigma(cvg::kGamma1),
               e.sigma(cvg::kGamma2),
               e.sigma(cvg::kMu1),
               e.sigma(cvg::kMu2),
               e.sigma(cvg::kDriveGain),
               e.residual_gamma1,
               e.residual_gamma2,
               e.normalised_innovation_squared,
               e.innovation[0],
               e.innovation[1],
               std::sqrt(e.innovation_covariance(0, 0)),
               std::sqrt(e.innovation_covariance(1, 1)),
               e.converged ? 1.0 : 0.0,
               cvg::toDegrees(e.angle_covered)});
  }
  return table.text();
}

// Means over windows of a tenth of a second, or longer when the run is long; locked blocks only.
std::string gainsCsv(const cvg::RunRecord& record) {
  Table table("time_s,theta_deg,a_V,beta_s,alpha,compensated");
  constexpr double kWindow = 0.1;  // [s]
  const auto& blocks = record.blocks();
  const auto window = static_cast<std::size_t>(std::lround(kWindow / record.blockDuration()));
  const std::size_t step = std::max({window, rowStep(blocks.size()), std::size_t{1}});
  for (std::size_t first = 0; first < blocks.size(); first += step) {
    double count = 0.0, time = 0.0, theta = 0.0, a = 0.0, beta = 0.0, alpha = 0.0;
    bool compensated = false;
    for (std::size_t i = first; i < std::min(first + step, blocks.size()); ++i) {
      const cvg::RunBlock& block = blocks[i];
      if (!block.has_elements || !block.has_gains || !block.status.locked()) continue;
      count += 1.0;
      time += record.time(block);
      theta += block.measured.theta;
      a += block.measured.a;
      beta += block.beta;
      alpha += block.alpha;
      compensated = block.compensation.gain1 != 0.0 || block.compensation.gain2 != 0.0;
    }
    if (count == 0.0) continue;
    table.row({time / count, cvg::toDegrees(theta / count), a / count, beta / count, alpha / count,
               compensated ? 1.0 : 0.0});
  }
  return table.text();
}

// Allan deviation of the sensed rate (total), and of the rate minus its dependence on the angle
// (residual).
std::string allanCsv(const cvg::RunRecord& record, const cvg::RunSummary& summary) {
  Table table("compensated,tau_s,total_deg_s,residual_deg_s,relative_sigma");
  for (const cvg::DriftResult* drift : {&summary.before, &summary.after}) {
    const cvg::SampleStretch stretch = cvg::longestStretch(drift->angles, record.blockDuration());
    std::vector<double> angles;
    for (std::size_t i = stretch.first; i < stretch.end; ++i) {
      angles.push_back(drift->angles[i].theta);
    }
    const auto total = cvg::allanDeviation(angles, record.blockDuration());
    std::vector<cvg::AllanPoint> residual;
    if (drift->harmonics) {
      residual = cvg::allanDeviation(cvg::angleResidual(drift->angles, stretch, *drift->harmonics),
                                     record.blockDuration());
    }
    for (std::size_t i = 0; i < total.size(); ++i) {
      table.row({drift == &summary.after ? 1.0 : 0.0, total[i].time,
                 cvg::toDegrees(total[i].deviation),
                 i < residual.size() ? cvg::toDegrees(residual[i].deviation) : NAN,
                 total[i].relative_sigma});
    }
  }
  return table.text();
}

// compensated: 0 before, 1 after.
std::string ratesCsv(const cvg::RunSummary& summary) {
  Table table("compensated,time_s,theta_deg,sensed_rate_deg_s");
  for (const cvg::DriftResult* drift : {&summary.before, &summary.after}) {
    if (!drift->harmonics) continue;
    for (const cvg::RateSample& sample : cvg::windowedRates(drift->angles)) {
      if (sample.time < drift->harmonics->begin_time) continue;
      table.row({drift == &summary.after ? 1.0 : 0.0, sample.time, cvg::toDegrees(sample.theta),
                 -cvg::toDegrees(sample.rate)});
    }
  }
  return table.text();
}

constexpr const char* kLoops = "/loops.csv";
constexpr const char* kRingUp = "/ring_up.csv";
constexpr const char* kGains = "/gains.csv";
constexpr const char* kEstimates = "/estimates.csv";
constexpr const char* kRates = "/rates.csv";
constexpr const char* kAllan = "/allan.csv";

}  // namespace

std::vector<std::string> seriesFiles(const std::string& directory) {
  std::vector<std::string> files;
  if (directory.empty()) return files;
  for (const char* name : {kLoops, kRingUp, kGains, kEstimates, kRates, kAllan}) {
    files.push_back(directory + name);
  }
  return files;
}

void makeSeriesFolder(const std::string& directory) {
  if (mkdir(directory.c_str(), 0777) != 0 && errno != EEXIST) {
    throw std::runtime_error(cvg::writeFault(directory, errno));
  }
}

void writeSeries(const cvg::RunRecord& record, const cvg::RunSummary& summary,
                 const std::string& directory) {
  cvg::writeWholeFile(directory + kLoops, loopsCsv(record));
  cvg::writeWholeFile(directory + kRingUp, ringUpCsv(record, summary));
  cvg::writeWholeFile(directory + kGains, gainsCsv(record));
  cvg::writeWholeFile(directory + kEstimates, estimatesCsv(record));
  cvg::writeWholeFile(directory + kRates, ratesCsv(summary));
  cvg::writeWholeFile(directory + kAllan, allanCsv(record, summary));
}

}  // namespace ring_gyro::tools
