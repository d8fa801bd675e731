#!/usr/bin/python3
"""Runs in which a node dies, or a file cannot be written, end by themselves and say so; blanks and
quotes in paths do no harm."""

import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

import rospkg
import rostest

PACKAGE = Path(rospkg.RosPack().get_path("ring_gyro"))
sys.path.insert(0, str(PACKAGE / "scripts"))
from free_ports import free_ports  # noqa: E402

PORTS = free_ports()
CONFIG = PACKAGE / "config" / "paper_simulation.yaml"


def executable(name: str) -> str:
    found = subprocess.run(["catkin_find", "--first-only", "--libexec", "ring_gyro", name],
                           check=True, capture_output=True, text=True)
    return found.stdout.strip()


def run(tool: str, *options) -> subprocess.CompletedProcess:
    return subprocess.run([executable(tool), *map(str, options)], check=False, capture_output=True,
                          text=True)


class Launch:
    """A launch with a master of its own, ended on leaving the block."""

    def __init__(self, folder: Path, name: str, **arguments):
        port = next(PORTS)
        self.log = tempfile.TemporaryFile("w+")
        self.environment = dict(os.environ, ROS_MASTER_URI=f"http://localhost:{port}",
                                ROS_HOSTNAME="localhost")
        self.process = subprocess.Popen(
            ["roslaunch", "-p", str(port), "ring_gyro", name]
            + [f"{key}:={value}" for key, value in arguments.items()],
            env=self.environment, cwd=folder, stdin=subprocess.DEVNULL, stdout=self.log, stderr=subprocess.STDOUT)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
            self.process.wait(60)
        self.log.close()

    def text(self) -> str:
        self.log.seek(0)
        return re.sub("\x1b\\[[0-9;]*m", "", self.log.read())

    def fatal(self) -> list:
        """What it said as FATAL, once it has ended by itself."""
        self.ended()
        return [line for line in self.text().splitlines() if "[FATAL]" in line]

    def ended(self) -> None:
        try:
            self.process.wait(60)
        except subprocess.TimeoutExpired:
            raise AssertionError("the launch does not end:\n" + self.text()) from None

    def wait_for(self, condition) -> None:
        give_up = time.monotonic() + 60
        while not condition():
            if time.monotonic() > give_up or self.process.poll() is not None:
                raise AssertionError(self.text())
            time.sleep(0.05)

    def kill(self, node: str) -> None:
        pid, = re.findall(fr"process\[{node}-\d+\]: started with pid \[(\d+)\]", self.text())
        os.kill(int(pid), signal.SIGKILL)


class BrokenRuns(unittest.TestCase):
    def setUp(self):
        self.scratch = tempfile.TemporaryDirectory(prefix="ring_gyro_broken_")
        self.folder = Path(self.scratch.name) / "it's a \"b\""
        self.folder.mkdir()
        self.bag = self.folder / "run.bag"

    def tearDown(self):
        self.scratch.cleanup()

    def launch(self, folder: Path, name: str = "simulation.launch", **arguments) -> Launch:
        """In the background, so that several take no longer than one."""
        launch = Launch(folder, name, **arguments)
        self.addCleanup(launch.__exit__)
        return launch

    def check_refused(self, launch: Launch, expected: str) -> None:
        said = launch.fatal()
        self.assertEqual(len([line for line in said if expected in line]), 1, launch.text())
        self.assertNotIn("end of the run", launch.text())

    def test_a_bag_that_cannot_be_written_ends_the_run(self):
        launches = []
        for record, expected in (
                ("/absent/run.bag", "/absent/run.bag: cannot be written: No such file or directory; "
                                    "the folder /absent does not exist"),
                ("~/run.bag", "node/bag = ~/run.bag: the shell has not replaced ~; give $HOME"),
                ("run.bag", "node/bag = run.bag: a relative path"),
                (self.folder, f"{self.folder}: cannot be written: Is a directory; name a file")):
            launches.append((self.launch(self.folder, record=record, duration=600), expected))
        for launch, expected in launches:
            self.check_refused(launch, expected)
        self.assertEqual(os.listdir(self.folder), [])
        home = Path(os.environ.get("ROS_HOME", Path.home() / ".ros"))
        self.assertFalse((home / "run.bag").exists())

    def test_a_full_disk_ends_the_run(self):
        # The limit of a file's size is inherited by all nodes; only the bag comes near it.
        before = resource.getrlimit(resource.RLIMIT_FSIZE)
        handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (2_000_000, before[1]))
        try:
            launch = Launch(self.folder, "simulation.launch", record=self.bag, duration=600)
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, before)
            signal.signal(signal.SIGXFSZ, handler)
        with launch:
            line, = launch.fatal()
            self.assertIn(f"{self.bag}: cannot be written: File too large", line)
        left, = self.folder.glob("run.bag.*.active")
        self.assertIn(str(left), line)
        self.assertFalse(self.bag.exists())

    def test_whoever_dies_ends_the_run(self):
        launches = []
        for node, *options in (("bag_recorder", "compensate"), ("control_loops",),
                               ("ekf_identifier", "compensate"), ("ekf_identifier",),
                               ("compensation_injector", "compensate"), ("plant_simulator",),
                               ("bag_recorder", "nodelets"), ("gyroscope", "nodelets")):
            folder = self.folder / "-".join((node, *options))
            folder.mkdir()
            launches.append((self.launch(folder, record=folder / "run.bag", duration=0,
                                         **{option: "true" for option in options}), node, folder))
        for launch, node, folder in launches:
            launch.wait_for(lambda: sum(path.stat().st_size for path in folder.glob(
                "run.bag.*.active")) > 1_000_000)
            launch.kill(node)
        for launch, node, folder in launches:
            launch.ended()
            self.assertRegex(launch.text(), fr"REQUIRED process \[{node}|/{node} has died: the run "
                                            "is cut after block")
            if node == "bag_recorder":
                left, = folder.glob("run.bag.*.active")
                self.assertIn(run("identify", left, "--config", CONFIG).returncode, (0, 2))
                self.assertFalse((folder / "run.bag").exists())
                continue
            self.assertEqual(list(folder.glob("run.bag.*")), [])
            done = run("validate_bag", folder / "run.bag")
            self.assertEqual(done.returncode, 1, done.stdout)
            self.assertIn("the run was cut after block", done.stdout)

    def test_rostopic_and_rosservice_understand_what_runs(self):
        launch = self.launch(self.folder, duration=0, lockstep="false", compensate="true")

        def said(*command) -> str:
            return subprocess.run(command, env=launch.environment, stdin=subprocess.DEVNULL,
                                  capture_output=True, text=True, timeout=60, check=False).stdout
        launch.wait_for(lambda: "simulated" in launch.text())
        self.assertIn("hardware_id", said("rostopic", "echo", "-n", "1", "/diagnostics"))
        self.assertIn("angular_velocity", said("rostopic", "echo", "-n", "1", "/imu"))
        for service, argument in (("enable", "false"), ("hold", "true"), ("reset", "")):
            self.assertIn("success: True", said(
                *f"rosservice call /compensation_injector/{service} {argument}".split()))

    def test_paths_with_blanks_and_quotes_and_inputs_that_stay(self):
        config = self.folder / "my config.yaml"
        shutil.copy(CONFIG, config)
        with Launch(self.folder, "simulation.launch", record=self.bag, config=config,
                    duration=2) as launch:
            self.assertEqual(launch.fatal(), [])
            self.assertIn(f"messages in {self.bag}", launch.text())
        self.assertEqual(run("validate_bag", self.bag).returncode, 0)
        result = self.folder / "my result.json"
        with Launch(self.folder, "identification.launch", bag=self.bag, config=config, rate=0,
                    json=result) as launch:
            launch.ended()
            self.assertTrue(result.exists(), launch.text())
        before = config.read_bytes()
        self.check_refused(self.launch(self.folder, record=config, config=config, duration=600),
                           "is an input too")
        self.assertEqual(config.read_bytes(), before)


if __name__ == "__main__":
    rostest.rosrun("ring_gyro", "broken_runs", BrokenRuns, sys.argv)
