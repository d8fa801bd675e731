// Runs the loop of a configuration for a second:  consumer CONFIG.yaml

#include <cstdio>

#include "ring_gyro/configuration/configuration_reader.h"
#include "ring_gyro/simulation/closed_loop.h"

int main(int, char** argv) {
  const cvg::LoopConfiguration configuration = cvg::readConfigurationFile(argv[1]);
  cvg::ClosedLoop loop(configuration);
  double angle = 0.0;
  while (loop.time() < 1.0) angle = loop.step().loops.elements.orbit.theta;
  std::printf("theta %.6f rad\n", angle);
  return 0;
}
