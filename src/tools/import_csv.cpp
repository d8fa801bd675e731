// rosrun ring_gyro import_csv: a lab's own log to a bag that the identifier reads.

#include <algorithm>
#include <boost/program_options.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "command_line.h"
#include "progress_bar.h"
#include "ring_gyro/common/angle.h"
#include "ring_gyro/common/output_target.h"
#include "ring_gyro/logs/log_importer.h"
#include "ring_gyro/logs/record_source.h"
#include "ring_gyro/ros/bag_writer.h"
#include "ring_gyro/ros/conversions.h"
#include "ring_gyro/ros/topics.h"

namespace ring_gyro::tools {
namespace {

namespace options = boost::program_options;

constexpr double kMegabyte = 1e6;

struct Arguments {
  std::string log_file;
  std::string bag_file;
  std::vector<std::string> columns;
  std::vector<std::string> constants;
  std::vector<std::string> ignored;
  cvg::CsvDialect dialect;
  cvg::ImportOptions import;
  bool dry_run = false;
};

char delimiterFrom(const std::string& name) {
  if (name == "tab" || name == "\\t") return '\t';
  if (name == "blank" || name == "space") return ' ';
  if (name == "comma") return ',';
  if (name == "semicolon") return ';';
  if (name.size() == 1) return name[0];
  throw options::error("--delimiter " + name + " must be one character, tab or blank");
}

char decimalFrom(const std::string& name) {
  if (name == "point" || name == ".") return '.';
  if (name == "comma" || name == ",") return ',';
  throw options::error("--decimal " + name + " must be point or comma");
}

cvg::ImportOptions::GainTiming timingFrom(const std::string& name) {
  if (name == "before") return cvg::ImportOptions::GainTiming::kBefore;
  if (name == "after") return cvg::ImportOptions::GainTiming::kAfter;
  if (name == "at") return cvg::ImportOptions::GainTiming::kAt;
  throw options::error("--gains " + name + " must be before, after or at");
}

/// Empty when the program has already printed what was requested (--help).
std::optional<Arguments> parse(int argc, char** argv) {
  Arguments arguments;
  cvg::ImportOptions& import = arguments.import;
  options::options_description description("import_csv");
  const auto text = [] { return options::value<std::string>(); };
  description.add_options()("help,h", "this text")("log", options::value(&arguments.log_file),
                                                   "text or MATLAB file (or the only argument)")(
      "output,o", options::value(&arguments.bag_file), "bag to write")(
      "dry-run", options::bool_switch(&arguments.dry_run), "only show how the log is read")(
      "column", options::value(&arguments.columns)->composing(),
      "quantity=[-]COLUMN[:UNIT], column by name or number from 1; may be repeated")(
      "constant", options::value(&arguments.constants)->composing(),
      "quantity=VALUE[UNIT] for one that has no column; may be repeated")(
      "ignore", options::value(&arguments.ignored)->composing(),
      "column or quantity that is not to be guessed; may be repeated")(
      "delimiter", text(), "of the fields: a character, tab or blank; otherwise guessed")(
      "decimal", text(), "point or comma; otherwise guessed")(
      "skip-lines", options::value(&arguments.dialect.skipped_lines), "at the begin of the file")(
      "sample-rate", text(), "rows a second, when time is no column or no good [Hz]")(
      "gains", text()->default_value("before"),
      "the gains of a row acted before its time, after it, or are values at it")(
      "group-delay", text(), "from a row's time back to where its motion is valid [s]")(
      "drive-gain", text(), "ks as the lab's loops assumed it, for virtual_rate [1/s^2]")(
      "drive-lead", text(),
      "from where the motion is valid to where the drive was pointed along it; otherwise to the "
      "middle of the time in which the drive acted [s]")(
      "phi-offset", text(), "to add to phi so that it is locked at -90 deg, such as -90deg [rad]")(
      "mirror", options::bool_switch(&import.mirror), "the lab's theta grows from x to -y")(
      "average", options::value(&import.average)->default_value(import.average),
      "rows in a block; 0: as many as make about 1 ms")(
      "minimum-amplitude", text(),
      "of the major axis, for a block to be used; otherwise 0.9 of the median over the first rows "
      "[V]")("attenuation", options::value(&import.stopband_attenuation),
             "of the demodulator at twice the reference, for samples [dB]")(
      "session", options::value(&import.session), "number of the run in the bag")(
      "partial", options::bool_switch(&import.partial),
      "leave out rows that cannot be used, and count them");
  const options::variables_map values = parseCommandLine(argc, argv, description, "log", 1);
  if (values.count("help") != 0) {
    std::string names;
    for (const cvg::QuantityInfo& info : cvg::quantities()) names += std::string(" ") + info.name;
    std::cout << "usage: import_csv LOG --output BAG [--column theta=-Angle:deg ...]\n"
              << description << "quantities:" << names << "\nsee docs/logs.md\n";
    return std::nullopt;
  }
  const auto quantity = [&](const char* name, cvg::Dimension dimension) -> std::optional<double> {
    if (values.count(name) == 0) return std::nullopt;
    return cvg::quantityFromText(std::string("--") + name, values[name].as<std::string>(),
                                 dimension);
  };
  if (values.count("delimiter") != 0) {
    arguments.dialect.delimiter = delimiterFrom(values["delimiter"].as<std::string>());
  }
  if (values.count("decimal") != 0) {
    arguments.dialect.decimal = decimalFrom(values["decimal"].as<std::string>());
  }
  import.gain_timing = timingFrom(values["gains"].as<std::string>());
  // The rate is rows per second, not converted to rad/s.
  if (const auto rate = quantity("sample-rate", cvg::Dimension::kAngularRate)) {
    const std::string& said = values["sample-rate"].as<std::string>();
    const bool counted = said.find_first_of("Hh") != std::string::npos;
    import.sample_rate = counted ? *rate / cvg::kTwoPi : *rate;
    if (!(*import.sample_rate > 0.0)) throw options::error("--sample-rate must be above zero");
  }
  import.drive_gain = quantity("drive-gain", cvg::Dimension::kNone);
  if (import.drive_gain && !(*import.drive_gain > 0.0)) {
    throw options::error("--drive-gain must be above zero");
  }
  import.drive_lead = quantity("drive-lead", cvg::Dimension::kTime);
  import.group_delay = quantity("group-delay", cvg::Dimension::kTime).value_or(0.0);
  import.phi_offset = quantity("phi-offset", cvg::Dimension::kAngle).value_or(0.0);
  import.minimum_amplitude = quantity("minimum-amplitude", cvg::Dimension::kVoltage);
  if (import.average < 0) {
    throw options::error("--average must be a number of rows, or 0: as many as make about 1 ms");
  }
  if (arguments.log_file.empty()) {
    throw options::error("the log is missing; see import_csv --help");
  }
  if (arguments.bag_file.empty() && !arguments.dry_run) {
    throw options::error("--output BAG is missing; see import_csv --help");
  }
  return arguments;
}

/// A bag of elements and gains, which appears complete or not at all.
class LogBag {
 public:
  explicit LogBag(const std::string& path) : writer_(path) {}
  ~LogBag() {
    if (!finished_) writer_.discard();
  }
  LogBag(const LogBag&) = delete;
  LogBag& operator=(const LogBag&) = delete;

  void write(const cvg::OrbitalElements& elements, const cvg::ControlGains& gains) {
    bridge::toMessage(elements, elements_);
    writer_.write(bridge::topics::kOrbitalElements, elements_);
    bridge::toMessage(gains, gains_);
    writer_.write(bridge::topics::kControlGains, gains_);
    last_ = elements.stamp;
  }

  void finish() {
    ring_gyro::EndOfRun end;
    end.header.stamp = bridge::timeFromNanoseconds(last_.end_ns);
    end.session = last_.session;
    end.last_sequence = last_.sequence;
    writer_.write(bridge::topics::kEndOfRun, end);
    writer_.finish();
    finished_ = true;
  }

 private:
  bridge::BagWriter writer_;
  cvg::BlockStamp last_;
  ring_gyro::OrbitalElements elements_;
  ring_gyro::ControlGains gains_;
  bool finished_ = false;
};

unsigned long number(std::uint64_t count) { return static_cast<unsigned long>(count); }

void printCounts(const cvg::ImportCounts& counts, const std::string& bag) {
  std::printf("imported   %lu rows, %.3f s, in %lu blocks to %s\n", number(counts.rows),
              counts.duration, number(counts.blocks), bag.c_str());
  std::printf("theta      %.3f to %.3f deg\n", cvg::toDegrees(counts.lowest_theta),
              cvg::toDegrees(counts.highest_theta));
  for (std::size_t k = 0; k < counts.faults.counts.size(); ++k) {
    if (counts.faults.counts[k] == 0) continue;
    std::printf("left out   %lu rows %s\n", number(counts.faults.counts[k]),
                cvg::toString(static_cast<cvg::RowFault>(k)));
  }
  if (counts.faults.total() > 0) std::printf("first      %s\n", counts.faults.first.c_str());
  if (counts.missing_rows > 0) std::printf("missing    %lu rows\n", number(counts.missing_rows));
  if (counts.left_over_rows > 0) {
    std::printf("left over  %lu rows of blocks that are not whole\n",
                number(counts.left_over_rows));
  }
  if (counts.unusable_blocks > 0) {
    std::printf("unusable   %lu blocks, not locked\n", number(counts.unusable_blocks));
  }
}

/// The identifier must be told a block length that differs from that of the presets.
void printIdentify(const cvg::LogImporter& importer, const std::string& bag) {
  constexpr double kUsualDuration = 1e-3;     // [s]
  constexpr double kUsualUpdatePeriod = 0.1;  // [s]
  constexpr double kSamples = 1000.0;         // per block, for the printed settings
  const double duration = 1e-9 * static_cast<double>(importer.blockDurationNanoseconds());
  std::printf("next       rosrun ring_gyro identify %s --config DEVICE.yaml", bag.c_str());
  if (duration != kUsualDuration) {
    const double blocks = std::max(1.0, std::round(kUsualUpdatePeriod / duration));
    std::printf(
        " --set converter/sample_rate=%.17g --set converter/block_samples=%.0f"
        " --set identification/update_period=%.17g",
        kSamples / duration, kSamples, blocks * duration);
  }
  std::printf("\n");
}

void warn(const std::string& file, const std::string& fault, const std::string& mend) {
  std::fprintf(stderr, "import_csv: warning: %s: %s; %s\n", file.c_str(), fault.c_str(),
               mend.c_str());
}

void judge(const cvg::ImportCounts& counts, const std::string& file) {
  if (counts.mean_beta < 0.0) {
    warn(file, "the sustain gain is negative on average", "turn its sign, --column beta=-COLUMN");
  }
  const double span = counts.highest_theta - counts.lowest_theta;
  if (span > cvg::kTwoPi * counts.duration) {
    warn(file, "theta turns faster than a turn a second",
         "if it is in degrees say --column theta=COLUMN:deg");
  }
  if (span < 0.5 * cvg::kPi) {
    warn(file, "theta covers less than a quarter of a turn",
         "gamma1 and gamma2 can only be told apart when the pattern turns");
  }
}

void run(const Arguments& arguments) {
  cvg::requireApart({arguments.bag_file}, {arguments.log_file});
  const std::unique_ptr<cvg::RecordSource> source =
      cvg::openLog(arguments.log_file, arguments.dialect);
  const cvg::ColumnMap map(arguments.log_file, source->names(), arguments.columns,
                           arguments.constants, arguments.ignored);
  cvg::LogImporter importer(*source, map, arguments.import);
  std::printf("%s: %s\n%s", arguments.log_file.c_str(), source->format().c_str(),
              map.table({importer.firstRow().data(),
                         importer.firstRow().data() + importer.firstRow().size()})
                  .c_str());
  std::printf("rows       every %.9g s, %ld in a block of %.9g s, group delay %s\n",
              importer.rowPeriod(), static_cast<long>(importer.rowsPerBlock()),
              1e-9 * static_cast<double>(importer.blockDurationNanoseconds()),
              importer.groupDelayText().c_str());
  std::fflush(stdout);
  if (arguments.dry_run) return;

  LogBag bag(arguments.bag_file);
  ProgressBar progress(source->size() / kMegabyte, "MB");
  const cvg::ImportCounts& counts =
      importer.run([&](const cvg::OrbitalElements& elements,
                       const cvg::ControlGains& gains) { bag.write(elements, gains); },
                   [&](double done, double) { progress.show(done / kMegabyte); });
  progress.clear();
  if (counts.blocks == counts.unusable_blocks) {
    throw cvg::LogError(
        arguments.log_file, "",
        counts.blocks == 0 ? "no block of it is whole" : "nothing in it is locked",
        "b must be small against a and phi near -90 deg; see --column, --phi-offset, "
        "--average");
  }
  bag.finish();
  printCounts(counts, arguments.bag_file);
  printIdentify(importer, arguments.bag_file);
  judge(counts, arguments.log_file);
}

}  // namespace
}  // namespace ring_gyro::tools

int main(int argc, char** argv) {
  try {
    if (const auto arguments = ring_gyro::tools::parse(argc, argv))
      ring_gyro::tools::run(*arguments);
    return EXIT_SUCCESS;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "import_csv: %s\n", error.what());
    return EXIT_FAILURE;
  }
}
