#include "node_main.h"
#include "ring_gyro/nodes/control_loops_node.h"

int main(int argc, char** argv) {
  return ring_gyro::runNode<ring_gyro::ControlLoopsNode>(argc, argv, "control_loops");
}
