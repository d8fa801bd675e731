#include "node_main.h"
#include "ring_gyro/nodes/ekf_identifier_node.h"

int main(int argc, char** argv) {
  return ring_gyro::nodes::runNode<ring_gyro::nodes::EkfIdentifierNode>(argc, argv,
                                                                        "ekf_identifier");
}
