#include "ring_gyro/configuration/node_parameters.h"

namespace cvg {

void NodeParameters::declare(ParameterTable& table) {
  table
      .flag("lockstep", lockstep,
            "the plant waits for the drive command that answers each block; otherwise it runs in "
            "real time")
      .number("lockstep_timeout", lockstep_timeout, "s", Range::between(0.1, 3600.0),
              "wall time without an answer that ends the run")
      .integer("required_subscribers", required_subscribers, Range::between(0, 1000),
               "subscribers that each output of the node must have before it takes any input")
      .integer("recorders", recorders, Range::between(0, 1000),
               "subscribers of end_of_run that stay until they are stopped, such as rosbag record")
      .number("exit_timeout", exit_timeout, "s", Range::between(0.1, 3600.0),
              "wall time that the plant waits at the end for the other nodes to exit")
      .integer(
          "burst_blocks", burst_blocks, Range::between(1, 1000),
          "blocks whose elements, gains and truth are sent together in lockstep, so that readers "
          "wake up less often; also sent at the end of each identifier period; in real time 1")
      .number("clock_rate", clock_rate, "Hz", Range::between(1.0, 100.0),
              "rate of /clock, in wall time")
      .text("imu_frame", imu_frame, "frame_id of the sensed rate")
      .text("watched", watched,
            "nodes, separated by blanks, whose death ends the run; a node that exits normally may "
            "be started again")
      .text("configuration_file", configuration_file,
            "file that these parameters come from; no output may be the same file")
      .text("calibration_read", calibration_read,
            "calibration file that these parameters also come from; no output may be the same file")
      .text("bag", bag, "file that the recorder writes")
      .flag("record_raw", record_raw,
            "also record samples and drive commands; plant and loops wait for the recorder to "
            "subscribe to them")
      .text("calibration_file", calibration_file, "YAML file that a calibration run writes")
      .text("report", report, "JSON file that the identifier writes at its end")
      .text("replay", replay,
            "bag whose replay the identifier listens to; the identifier exits when it has received "
            "all of it")
      .number("replay_start", replay_start, "s", Range::between(0.0, 1e9),
              "start of that replay, from the beginning of the bag")
      .number("replay_duration", replay_duration, "s", Range::between(0.0, 1e9),
              "duration of that replay; 0: to the end of the bag")
      .number("replay_timeout", replay_timeout, "s", Range::between(0.1, 1e6),
              "wall time without messages that ends a replay without /clock");
}

}  // namespace cvg
