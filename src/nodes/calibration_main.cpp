#include "node_main.h"
#include "ring_gyro/nodes/calibration_node.h"

int main(int argc, char** argv) {
  return ring_gyro::nodes::runNode<ring_gyro::nodes::CalibrationNode>(argc, argv, "calibration");
}
