// Turns elements of the core into the message that the nodes publish.

#include <cstdio>

#include "ring_gyro/ros/conversions.h"

int main() {
  cvg::OrbitalElements elements;
  elements.orbit.theta = 0.5;
  ring_gyro::OrbitalElements message;
  ring_gyro::bridge::toMessage(elements, message);
  std::printf("theta %.1f rad in the message\n", message.theta);
  return message.theta == elements.orbit.theta ? 0 : 1;
}
