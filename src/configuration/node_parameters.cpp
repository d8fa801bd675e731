#include "ring_gyro/configuration/node_parameters.h"

namespace cvg {

void NodeParameters::declare(ParameterTable& table) {
  table
      .flag("lockstep", lockstep,
            "the plant waits for the drive command that answers each block; otherwise it runs in "
            "real time")
      .number("lockstep_timeout", lockstep_timeout, "s", Range::between(0.1, 3600.0),
              "wall time without an answer after which the run is given up")
      .integer("required_subscribers", required_subscribers, Range::between(0, 1000),
               "subscribers that each output of the node must have before it takes any input")
      .integer("recorders", recorders, Range::between(0, 1000),
               "subscribers of end_of_run that stay until they are stopped, such as rosbag record")
      .number("exit_timeout", exit_timeout, "s", Range::between(0.1, 3600.0),
              "wall time that the plant waits at the end for the other nodes")
      .integer("burst_blocks", burst_blocks, Range::between(1, 1000),
               "blocks whose elements, gains and truth are sent together in lockstep, and at each "
               "end of an identifier period: the readers wake up less often; in real time 1")
      .number("clock_rate", clock_rate, "Hz", Range::between(1.0, 100.0), "of /clock, in wall time")
      .text("imu_frame", imu_frame, "frame_id of the sensed rate")
      .text("watched", watched,
            "nodes, blanks between, whose death ends the run of the plant; one that ends in order "
            "may be started again")
      .text("configuration_file", configuration_file,
            "that these parameters come from: no output may be the same file")
      .text("calibration_read", calibration_read,
            "calibration that these parameters come from too: no output may be the same file")
      .text("bag", bag, "file that the recorder writes")
      .flag("record_raw", record_raw,
            "samples and drive commands are recorded too; plant and loops wait for the listener to "
            "them")
      .text("calibration_file", calibration_file, "YAML file that a calibration run writes")
      .text("report", report, "JSON file that the identifier writes at its end")
      .text("replay", replay,
            "bag whose replay the identifier listens to: it ends when all of it has come")
      .number("replay_start", replay_start, "s", Range::between(0.0, 1e9),
              "where that replay begins, from the begin of the bag")
      .number("replay_duration", replay_duration, "s", Range::between(0.0, 1e9),
              "of that replay; 0: to the end of the bag")
      .number("replay_timeout", replay_timeout, "s", Range::between(0.1, 1e6),
              "wall time of silence that ends a replay without /clock");
}

}  // namespace cvg
