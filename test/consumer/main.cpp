// Runs the loop of a configuration for a second, writes it as a log and reads that:
//   consumer CONFIG.yaml LOG.csv

#include <cstddef>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include "ring_gyro/configuration/configuration_reader.h"
#include "ring_gyro/logs/log_table.h"
#include "ring_gyro/logs/record_source.h"
#include "ring_gyro/simulation/closed_loop.h"

int main(int, char** argv) {
  const cvg::LoopConfiguration configuration = cvg::readConfigurationFile(argv[1]);
  cvg::ClosedLoop loop(configuration);
  std::string text = cvg::logHeader();
  double theta = 0.0;
  std::size_t blocks = 0;
  for (; loop.time() < 1.0; ++blocks) {
    const cvg::LoopOutput& loops = loop.step().loops;
    theta = loops.elements.orbit.theta;
    cvg::appendLogRow(loops.elements, loops.gains, text);
  }
  std::ofstream(argv[2]) << text;

  std::size_t rows = 0;
  std::vector<double> values;
  const auto log = cvg::openLog(argv[2]);
  log->select({0});
  while (log->next(values)) ++rows;
  std::printf("theta %.6f rad after %zu blocks, %zu rows in the log\n", theta, blocks, rows);
  return rows == blocks ? 0 : 1;
}
