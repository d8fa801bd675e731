#include "node_main.h"
#include "ring_gyro/nodes/compensation_injector_node.h"

int main(int argc, char** argv) {
  return ring_gyro::nodes::runNode<ring_gyro::nodes::CompensationInjectorNode>(
      argc, argv, "compensation_injector");
}
