#include "node_main.h"
#include "ring_gyro/nodes/compensation_injector_node.h"

int main(int argc, char** argv) {
  return ring_gyro::runNode<ring_gyro::CompensationInjectorNode>(argc, argv,
                                                                 "compensation_injector");
}
