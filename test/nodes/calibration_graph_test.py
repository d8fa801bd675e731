#!/usr/bin/python3
"""A calibration run in the graph leaves the file that it leaves in one process, byte for byte, and
the loops load it."""

import io
import json
import os
import signal
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import rosbag
import rospkg
import rostest
import yaml

PACKAGE = Path(rospkg.RosPack().get_path("ring_gyro"))
sys.path.insert(0, str(PACKAGE / "scripts"))
from free_ports import free_ports  # noqa: E402

PORTS = free_ports()
CONFIG = PACKAGE / "test" / "short_calibration.yaml"
PERIOD = 100  # blocks
TABLE_RATE = 5.0  # in that file [rad/s]


def executable(name: str) -> str:
    found = subprocess.run(["catkin_find", "--first-only", "--libexec", "ring_gyro", name],
                           check=True, capture_output=True, text=True)
    return found.stdout.strip()


def run(tool: str, *options, status: int = 0) -> str:
    """What it says on standard error; it must end with this status."""
    done = subprocess.run([executable(tool)] + [str(option) for option in options], check=False,
                          stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    if done.returncode != status:
        raise AssertionError(f"{tool} ended with {done.returncode}: {done.stderr}")
    return done.stderr


def launch(name: str, **arguments) -> str:
    """What the launch says; it must end by itself."""
    port = next(PORTS)
    texts = [f"{key}:={value}" for key, value in arguments.items()]
    process = subprocess.Popen(
        ["roslaunch", "-p", str(port), "ring_gyro", name] + texts, text=True,
        env=dict(os.environ, ROS_MASTER_URI=f"http://localhost:{port}", ROS_HOSTNAME="localhost"),
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    try:
        return process.communicate(timeout=120)[0]
    except subprocess.TimeoutExpired:
        process.send_signal(signal.SIGINT)
        raise AssertionError("the launch does not end:\n" + process.communicate(timeout=60)[0])


def messages(bag: Path, topic: str) -> list:
    with rosbag.Bag(str(bag)) as recorded:
        return [message for _, message, _ in recorded.read_messages([topic, "/" + topic])]


def message_count(bag: Path, topic: str) -> int:
    """From the index, without reading them."""
    with rosbag.Bag(str(bag)) as recorded:
        return recorded.get_message_count([topic, "/" + topic])


def contents(message) -> bytes:
    """Of a message; the sequence number of the header belongs to the transport."""
    message.header.seq = 0
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


class CalibrationGraph(unittest.TestCase):
    def setUp(self):
        self.folder_handle = tempfile.TemporaryDirectory(prefix="ring_gyro_calibration_")
        self.folder = Path(self.folder_handle.name)

    def tearDown(self):
        self.folder_handle.cleanup()

    def calibrate(self, config: Path, **arguments) -> tuple:
        """The file that the run leaves (None without one), the recorded commands and the log."""
        calibration, bag = self.folder / "calibration.yaml", self.folder / "calibration.bag"
        for path in (calibration, bag):
            if path.exists():
                path.unlink()
        log = launch("calibration.launch", config=config, calibration=calibration, record=bag,
                     **arguments)
        self.assertTrue(bag.exists(), log)
        written = calibration.read_bytes() if calibration.exists() else None
        return written, self.commands_of_whole(bag), log

    def commands_of_whole(self, bag: Path) -> list:
        """The commands of a bag, which must hold every block up to the announced end."""
        ends = messages(bag, "end_of_run")
        self.assertEqual(len(ends), 1)
        blocks = ends[0].last_sequence + 1
        self.assertEqual(blocks % PERIOD, 0)
        for topic in ("orbital_elements", "control_gains", "plant_truth"):
            self.assertEqual(message_count(bag, topic), blocks, topic)
        commands = messages(bag, "calibration_command")
        self.assertEqual([command.data_sequence for command in commands],
                         list(range(PERIOD - 1, blocks, PERIOD)))
        self.assertEqual([command.end_of_run for command in commands],
                         [False] * (len(commands) - 2) + [True, True])
        return commands

    def test_same_calibration_in_processes_nodelets_and_one_process(self):
        expected = self.folder / "expected.yaml"
        run("calibrate", "--config", CONFIG, "--output", expected)
        for nodelets in ("false", "true"):
            with self.subTest(nodelets=nodelets):
                written, commands, log = self.calibrate(CONFIG, nodelets=nodelets)
                self.assertEqual(written, expected.read_bytes(), log)
                self.assertTrue(commands[-1].finished)
                self.assertEqual((commands[-1].failure, commands[-1].time_left), ("", 0.0))
                self.assertIn(TABLE_RATE, [command.table_rate for command in commands])
                self.assertIn("calibration in ", log)

    def test_a_run_that_cannot_go_on_says_why_and_leaves_no_file(self):
        config = self.folder / "locked_pattern.yaml"
        config.write_text(CONFIG.read_text().replace("gamma1: 0.01", "gamma1: 0.45"))
        written, commands, log = self.calibrate(config)
        self.assertIsNone(written)
        reason = "raise calibration_run/survey_rate above the drift"
        self.assertIn(reason, commands[-1].failure)
        fatal = [line for line in log.splitlines() if "FATAL" in line]
        self.assertEqual(len(fatal), 1, log)
        self.assertIn(reason, fatal[0])
        self.assertRegex(log, r"calibration-\d+\] has died!\nprocess has died .*exit code 1")

    def config_with(self, name: str, told: float, of_ring: float) -> Path:
        """The short run with these angular gains."""
        config = self.folder / f"{name}.yaml"
        text = CONFIG.read_text()
        for section, gain in (("device", told), ("resonator", of_ring)):
            text = text.replace(f"\n{section}:\n", f"\n{section}:\n  angular_gain: {gain}\n")
        config.write_text(text)
        return config

    def test_a_run_that_fails_later_keeps_what_it_had_found(self):
        config = self.config_with("still_table", 1.0, 0.0)
        alone = self.folder / "alone.yaml"
        alone.write_text("of an earlier run\n")
        said = run("calibrate", "--config", config, "--output", alone, status=1)
        kept = Path(f"{alone}.partial")
        self.assertIn(f"does the table turn?; what had been found is in {kept}", said)
        self.assertEqual(alone.read_text(), "of an earlier run\n")
        self.assertIn("# PARTIAL: the run has not ended. Missing: angle map, verification, rate "
                      "threshold.\n", kept.read_text())
        bag = self.folder / "with_partial.bag"
        run("simulate", "--config", config, "--config", kept, "--duration", 0.2, "--output", bag)
        written, commands, log = self.calibrate(config)
        self.assertIsNone(written)
        self.assertIn("angle map", commands[-1].failure)
        partial = self.folder / "calibration.yaml.partial"
        self.assertEqual(partial.read_bytes(), kept.read_bytes())
        fatal = [line for line in log.splitlines() if "FATAL" in line]
        self.assertEqual(len(fatal), 1, log)
        self.assertIn(f"what had been found is in {partial}", fatal[0])

    def test_any_angular_gain_is_calibrated_read_and_judged(self):
        for told, of_ring in ((0.37, 0.37), (1.0, 0.37), (0.9, 0.9)):
            with self.subTest(told=told, of_ring=of_ring):
                config = self.config_with("gain", told, of_ring)
                calibration, judged = self.folder / "gain_found.yaml", self.folder / "judged.json"
                run("calibrate", "--config", config, "--output", calibration)
                self.assertFalse(Path(f"{calibration}.partial").exists())
                found = yaml.safe_load(calibration.read_text())["device"]["angular_gain"]
                self.assertAlmostEqual(found / of_ring, 1.0, delta=1e-4)
                run("judge_calibration", "--config", config, "--config", calibration, "--time", 3,
                    "--json", judged)
                rows = json.loads(judged.read_text())
                self.assertEqual([row["rate"] for row in rows], [5.0])
                self.assertLess(rows[0]["threshold"], 0.02)  # 0.17 when it is not calibrated

    def test_a_judgement_that_cannot_be_made_is_no_success(self):
        judged = self.folder / "judged.json"
        said = run("judge_calibration", "--config", CONFIG, "--time", 1, "--json", judged,
                   "--set", "calibration_run/verification_rates=[5.0, 0.001]",
                   "--set", "resonator/angular_gain=0.0", status=2)
        self.assertIn("2 of 2 judgements could not be made", said)
        self.assertEqual(["failure" in row for row in json.loads(judged.read_text())],
                         [True, True])

    def test_the_loops_load_a_calibration_over_their_configuration(self):
        calibration = self.folder / "calibration.yaml"
        # 1e-03 is text to rosparam.
        calibration.write_text(
            "device:\n  drive_gain: 1030000\n"
            "calibration:\n  pickoff_cubic: 2e-02\n  drive_rotation: -3e-07\n"
            "  drift_constant: 1e-03\n"
            "  drift_cosine: [0, 2e-02, 0, 2e-07]\n  drift_sine: [0, 1e-03, 0, 0.5]\n"
            "  angle_map_cosine: [0, 0.01]\n  angle_map_sine: []\n")
        live, offline = self.folder / "live.bag", self.folder / "offline.bag"
        log = launch("simulation.launch", config=CONFIG, calibration=calibration, duration=3,
                     identify="false", record=live)
        run("simulate", "--config", CONFIG, "--config", calibration, "--duration", 3, "--output",
            offline)
        elements, gains = messages(live, "orbital_elements"), messages(live, "control_gains")
        self.assertEqual((len(elements), len(gains)), (3000, 3000), log)
        self.assertEqual([contents(message) for message in elements],
                         [contents(message) for message in messages(offline, "orbital_elements")])
        self.assertEqual([contents(message) for message in gains],
                         [contents(message) for message in messages(offline, "control_gains")])
        self.assertNotEqual(elements[-1].angle, elements[-1].theta)
        self.assertGreater(max(abs(message.virtual_rate) for message in gains), 0.02)


if __name__ == "__main__":
    rostest.rosrun("ring_gyro", "calibration_graph", CalibrationGraph, sys.argv)
