#include "node_main.h"
#include "ring_gyro/nodes/plant_simulator_node.h"

int main(int argc, char** argv) {
  return ring_gyro::nodes::runNode<ring_gyro::nodes::PlantSimulatorNode>(argc, argv,
                                                                         "plant_simulator", true);
}
