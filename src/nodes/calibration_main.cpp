#include "node_main.h"
#include "ring_gyro/nodes/calibration_node.h"

int main(int argc, char** argv) {
  return ring_gyro::runNode<ring_gyro::CalibrationNode>(argc, argv, "calibration");
}
