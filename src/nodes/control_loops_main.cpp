#include "node_main.h"
#include "ring_gyro/nodes/control_loops_node.h"

int main(int argc, char** argv) {
  return ring_gyro::nodes::runNode<ring_gyro::nodes::ControlLoopsNode>(argc, argv, "control_loops");
}
