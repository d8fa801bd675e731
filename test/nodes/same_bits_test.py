#!/usr/bin/python3
"""Live estimates, those of identify on the recorded bag, and those of the node to which the bag is
replayed are the same to the last bit, all that is published of them."""

import io
import json
import os
import pickle
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

import rosbag
import rospkg
import rostest
from ring_gyro.msg import ParameterEstimate

PACKAGE = Path(rospkg.RosPack().get_path("ring_gyro"))
sys.path.insert(0, str(PACKAGE / "scripts"))
from free_ports import free_ports  # noqa: E402

PORTS = free_ports()
CONFIG = PACKAGE / "config" / "paper_simulation.yaml"
COLLECTOR = """
import pickle, sys, rospy
from rospy import AnyMsg
count, path = int(sys.argv[1]), sys.argv[2]
messages = []
rospy.init_node("collector", anonymous=True, disable_signals=True)
subscriber = rospy.Subscriber("/parameter_estimate", AnyMsg, lambda m: messages.append(m._buff))
while len(messages) < count and not rospy.is_shutdown():
    rospy.rostime.wallsleep(0.02)
rospy.rostime.wallsleep(0.3)  # for any that should not be there
subscriber.unregister()
with open(path, "wb") as file:
    pickle.dump(messages, file)
"""


def environment(port: int) -> dict:
    return dict(os.environ, ROS_MASTER_URI=f"http://localhost:{port}", ROS_HOSTNAME="localhost")


def executable(name: str) -> str:
    found = subprocess.run(["catkin_find", "--first-only", "--libexec", "ring_gyro", name],
                           check=True, capture_output=True, text=True)
    return found.stdout.strip()


def stop(process: subprocess.Popen) -> None:
    if process.poll() is None:
        process.send_signal(signal.SIGINT)
        process.wait(60)


def contents(message) -> bytes:
    """Of a message; the sequence number of the header belongs to the transport."""
    message.header.seq = 0
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


def estimates(bag: Path) -> list:
    with rosbag.Bag(str(bag)) as recorded:
        return [message for topic, message, _ in recorded.read_messages()
                if topic.lstrip("/") == "parameter_estimate"]


def in_file_order(bag: Path) -> list:
    """Topic and bag time in seconds of each message, as they lie in the file."""
    with rosbag.Bag(str(bag)) as recorded:
        topics = {number: connection.topic.lstrip("/")
                  for number, connection in recorded._connections.items()}
        entries = [(entry.chunk_pos, entry.offset, topics[number], entry.time.to_sec())
                   for number, index in recorded._connection_indexes.items() for entry in index]
    return [(topic, at) for _, _, topic, at in sorted(entries)]


class SameBits(unittest.TestCase):
    def setUp(self):
        self.folder_handle = tempfile.TemporaryDirectory(prefix="ring_gyro_same_bits_")
        self.folder = Path(self.folder_handle.name)
        self.processes = []

    def tearDown(self):
        for process in self.processes:
            stop(process)
        self.folder_handle.cleanup()

    def start(self, command: list, port: int) -> subprocess.Popen:
        process = subprocess.Popen([str(part) for part in command], env=environment(port),
                                   stdout=subprocess.DEVNULL, stdin=subprocess.DEVNULL)
        self.processes.append(process)
        return process

    def launch(self, port: int, name: str, **arguments) -> subprocess.Popen:
        texts = [f"{key}:={value}" for key, value in arguments.items()]
        return self.start(["roslaunch", "-p", port, "ring_gyro", name] + texts, port)

    def record(self, bag: Path, **arguments) -> None:
        port = next(PORTS)
        self.assertEqual(self.launch(port, "simulation.launch", config=CONFIG, record=bag,
                                     **arguments).wait(240), 0)
        self.assertTrue(bag.exists())

    def identify(self, bag: Path, *options) -> tuple:
        """Estimates and JSON of the tool; it must find nothing wrong with the data."""
        out, report = self.folder / "offline.bag", self.folder / "offline.json"
        subprocess.run([executable("identify"), str(bag), "--config", str(CONFIG), "--estimates",
                        str(out), "--json", str(report)] + [str(o) for o in options],
                       check=True, stdout=subprocess.DEVNULL)
        return estimates(out), report.read_bytes()

    def replay(self, bag: Path, count: int, **arguments) -> tuple:
        """All estimates that the node published, as bytes, and its JSON."""
        port = next(PORTS)
        out, report = self.folder / "collected", self.folder / "replayed.json"
        for path in (out, report):
            if path.exists():
                path.unlink()
        launched = self.launch(port, "identification.launch", bag=bag, config=CONFIG, json=report,
                               required_subscribers=1, **arguments)
        # A ROS node waits for its master.
        collector = self.start([sys.executable, "-c", COLLECTOR, count, out], port)
        self.assertEqual(launched.wait(120), 0, "the launch must end by itself")
        stop(collector)
        with open(out, "rb") as file:
            messages = [ParameterEstimate().deserialize(data) for data in pickle.load(file)]
        return messages, report.read_bytes()

    def blocks_seen(self, port: int) -> int:
        """Of the identifier that runs; 0 when there is none yet."""
        # It gives up at once when there is no master yet.
        seen = subprocess.run(["rostopic", "echo", "-p", "-n", "1", "/parameter_estimate"],
                              env=environment(port), capture_output=True, timeout=120,
                              check=False, text=True).stdout.splitlines()
        if len(seen) != 2:
            return 0
        estimate = dict(zip(seen[0].split(","), seen[1].split(",")))
        return int(estimate["field.last_sequence"]) - int(estimate["field.first_sequence"])

    def wait_for(self, condition) -> None:
        deadline = time.monotonic() + 120
        while not condition():
            self.assertLess(time.monotonic(), deadline, "not in two minutes")
            time.sleep(0.1)

    def wait_for_estimate(self, port: int, after: int) -> None:
        """Of the identifier that runs, once it has seen more than so many blocks."""
        self.wait_for(lambda: self.blocks_seen(port) >= after)

    def assertSame(self, one: list, other: list):
        self.assertEqual(len(one), len(other))
        for index, (a, b) in enumerate(zip(one, other)):
            self.assertEqual(contents(a), contents(b), f"estimate {index}")

    def test_live_offline_and_replayed_with_compensation(self):
        bag = self.folder / "live.bag"
        self.record(bag, duration=20, compensate="true", compensate_after=5)
        live = estimates(bag)
        self.assertEqual(len(live), 200)
        with rosbag.Bag(str(bag)) as recorded:
            acted = [message for topic, message, _ in recorded.read_messages()
                     if topic.lstrip("/") == "control_gains" and message.compensation_gain1 != 0]
        self.assertGreater(len(acted), 1000, "the compensation must have acted")

        offline, report = self.identify(bag)
        self.assertSame(live, offline)

        replayed, replayed_report = self.replay(bag, len(live), rate=0)
        self.assertSame(live, replayed)
        self.assertEqual(report, replayed_report)
        self.assertEqual(json.loads(report)["runs"][0]["counts"]["not_delivered"], 0)

        part, part_report = self.identify(bag, "--start", 7, "--duration", 4)
        replayed, replayed_report = self.replay(bag, len(part), rate=1, start=7, duration=4)
        self.assertGreater(len(part), 35)
        self.assertSame(part, replayed)
        self.assertEqual(part_report, replayed_report)

        # A player that holds back one message only loses most; the node says how many.
        port = next(PORTS)
        lossy = self.folder / "lossy.json"
        self.assertEqual(self.launch(port, "identification.launch", bag=bag, config=CONFIG,
                                     json=lossy, rate=0, queue=1).wait(120), 0)
        run = json.loads(lossy.read_text())["runs"][0]
        counts = run["counts"]
        self.assertGreater(counts["not_delivered"], 0)
        self.assertEqual(2 * counts["pairs"] + counts["elements_without_gains"]
                         + counts["gains_without_elements"] + counts["not_delivered"], 40000)
        self.assertIn("not delivered", " ".join(run["faults"]))

    def test_recorded_in_the_order_of_the_stamps(self):
        # Nodelets send faster than sockets are read: the recorder gets one topic after the other.
        bag = self.folder / "nodelets.bag"
        self.record(bag, duration=20, compensate="true", nodelets="true")
        messages = in_file_order(bag)
        self.assertEqual(len(messages), 3 * 20000 + 2 * 200 + 1)
        times = [at for _, at in messages]
        self.assertEqual(times, sorted(times))
        for topic in ("orbital_elements", "control_gains", "plant_truth"):
            places = [place for place, (name, _) in enumerate(messages) if name == topic]
            self.assertLessEqual(max(b - a for a, b in zip(places, places[1:])), 5)
        self.assertEqual(messages[-1][0], "end_of_run")

    def test_raw_samples_are_recorded_from_the_first_block_on(self):
        # The recorder listens to what plant and loops send each other, and is not taken for them.
        for nodelets in ("true", "false"):
            bag = self.folder / "raw.bag"
            self.record(bag, duration=2, nodelets=nodelets, record_raw="true")
            topics = [topic for topic, _ in in_file_order(bag)]
            for topic in ("displacement", "drive_command", "orbital_elements"):
                self.assertEqual(topics.count(topic), 2000, topic)

    def test_identifier_restarted_in_the_middle(self):
        bag = self.folder / "restarted.bag"
        port = next(PORTS)
        # The run goes on until both identifiers have been seen, on a machine of any speed.
        launched = self.launch(port, "simulation.launch", config=CONFIG, record=bag, duration=0)
        self.wait_for_estimate(port, after=1000)
        self.start(["rosnode", "kill", "/ekf_identifier"], port).wait(60)
        # Its parameters are still on the server.
        second = self.start([executable("ekf_identifier_node"), "__name:=ekf_identifier"], port)
        self.wait_for_estimate(port, after=10000)
        stop(launched)
        stop(second)

        recorded = estimates(bag)
        starts = sorted({message.first_sequence for message in recorded})
        self.assertEqual(len(starts), 2, "the run must see both identifiers")
        self.assertEqual(starts[0], 0)
        first = [message for message in recorded if message.first_sequence == starts[0]]
        second = [message for message in recorded if message.first_sequence == starts[1]]
        self.assertGreater(len(second), 50)
        offline, _ = self.identify(bag, "--start-sequence", starts[1])
        # The recorder was stopped too: what the last data in its bag say may have come too late for it.
        self.assertSame(second, offline[:len(second)])
        offline, _ = self.identify(bag)
        self.assertSame(first, offline[:len(first)])


if __name__ == "__main__":
    rostest.rosrun("ring_gyro", "same_bits", SameBits, sys.argv)
