#include "node_main.h"
#include "ring_gyro/nodes/bag_recorder_node.h"

int main(int argc, char** argv) {
  return ring_gyro::nodes::runNode<ring_gyro::nodes::BagRecorderNode>(argc, argv, "bag_recorder");
}
