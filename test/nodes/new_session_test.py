#!/usr/bin/python3
"""A plant that dies in the middle of a run and is started again: nothing of the old session acts in
the new one."""

import os
import signal
import subprocess
import sys
import threading
import time
import unittest
import xmlrpc.client

import rosgraph
import rospy
import rostest
from ring_gyro.msg import ControlGains, OrbitalElements, PlantTruth

ME = "/new_session_test"


class Kept:
    """What came on a topic, by session and sequence, not unpacked."""

    def __init__(self, topic, message_type):
        self.message_type = message_type
        self.lock = threading.Lock()
        self.messages = []
        self.subscriber = rospy.Subscriber(topic, rospy.AnyMsg, self.take, tcp_nodelay=True)

    def take(self, message):
        with self.lock:
            self.messages.append(message._buff)

    def last(self):
        with self.lock:
            return self.unpack(self.messages[-1]) if self.messages else None

    def of_session(self, session):
        with self.lock:
            messages = list(self.messages)
        found = [m for m in messages if int.from_bytes(self.session_bytes(m), "little") == session]
        return [self.unpack(m) for m in found]

    @staticmethod
    def session_bytes(buffer):
        frame = int.from_bytes(buffer[12:16], "little")  # behind seq and stamp of the header
        return buffer[16 + frame:20 + frame]

    def unpack(self, buffer):
        return self.message_type().deserialize(buffer)


def wait_for(what, condition):
    deadline = time.monotonic() + 100
    while time.monotonic() < deadline:
        found = condition()
        if found:
            return found
        time.sleep(0.05)
    raise AssertionError(f"no {what} within 100 s")


def plant_pid():
    master = rosgraph.Master(ME)
    return xmlrpc.client.ServerProxy(master.lookupNode("/plant_simulator")).getPid(ME)[2]


class NewSession(unittest.TestCase):
    def test_finds_everything_as_newly_started(self):
        # Not before the nodes have found each other: nobody waits for this one.
        wait_for("run", lambda: rospy.wait_for_message("/plant_truth", PlantTruth).sequence > 300)
        elements, gains = Kept("/orbital_elements", OrbitalElements), Kept("/control_gains",
                                                                           ControlGains)
        first = wait_for("elements", elements.last).session
        wait_for("compensation", lambda: gains.last() and abs(gains.last().compensation_gain2) > 0)
        self.assertGreater(abs(elements.last().theta), 1.0)

        os.kill(plant_pid(), signal.SIGKILL)
        program = subprocess.run(["catkin_find", "--first-only", "--libexec", "ring_gyro",
                                  "plant_simulator_node"], check=True, capture_output=True,
                                 text=True).stdout.strip()
        plant = subprocess.Popen([program, "__name:=plant_simulator"])
        try:
            second = wait_for("new session", lambda: elements.last().session != first and
                              elements.last()).session
            self.assertEqual(second, first + 1)
            wait_for("locked loops", lambda: elements.last().status.phase_locked and
                     elements.last().status.amplitude_locked)
            wait_for("three seconds", lambda: elements.last().sequence > 3000)
        finally:
            plant.send_signal(signal.SIGINT)
            plant.wait(60)
        new_elements, new_gains = elements.of_session(second), gains.of_session(second)
        self.assertEqual([e.sequence for e in new_elements], list(range(len(new_elements))))
        self.assertLess(new_elements[0].a, 0.01, "the new ring is at rest")
        self.assertLess(abs(new_elements[1000].theta), 3.2, "turns are counted afresh")
        locked = [e.sequence for e in new_elements if e.status.phase_locked and
                  e.status.amplitude_locked and e.status.quadrature_locked]
        self.assertLess(locked[0], 1000)
        self.assertEqual({g.compensation_gain1 for g in new_gains[:3000]}, {0.0})
        self.assertEqual({g.compensation_gain2 for g in new_gains[:3000]}, {0.0})


if __name__ == "__main__":
    rospy.init_node("new_session_test", disable_rostime=True)
    rostest.rosrun("ring_gyro", "new_session", NewSession, sys.argv)
