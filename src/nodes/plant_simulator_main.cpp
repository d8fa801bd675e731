#include "node_main.h"
#include "ring_gyro/nodes/plant_simulator_node.h"

int main(int argc, char** argv) {
  return ring_gyro::runNode<ring_gyro::PlantSimulatorNode>(argc, argv, "plant_simulator", true);
}
