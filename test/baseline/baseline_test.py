#!/usr/bin/python3
"""What the programs make today against what they made when the baseline was recorded: see
README.md.

usage: baseline_test.py FOLDER_OF_PROGRAMS CONFIG_FOLDER [RESULT.xml]
       baseline_test.py FOLDER_OF_PROGRAMS CONFIG_FOLDER --record COMMIT [--keep-bag]
"""

import hashlib
import json
import math
import os
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import rosbag

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import junit  # noqa: E402

PROGRAMS, CONFIG = Path(sys.argv[1]), Path(sys.argv[2])
KEPT = Path(__file__).resolve().parent
TESTS = KEPT.parent
RAW = ("displacement", "drive_command")
AFTER_LOCK, RAW_AFTER_LOCK = 5.0, 0.5  # what the kept bag holds [s]
LONG_RUN = 20.0  # whose contents are kept as digests [s]

# On another processor or with another compiler numbers may differ by rounding.
ROUNDING = 1e-9  # of a signal, absolute (V, rad, s) and relative
VALUE_IN_SIGMA, SIGMA = 1e-3, 1e-6  # of an estimate


def program(name: str, *arguments) -> str:
    done = subprocess.run([str(PROGRAMS / name), *map(str, arguments)], check=False, text=True,
                          stdin=subprocess.DEVNULL, capture_output=True)
    if done.returncode != 0:
        raise AssertionError(f"{name} {arguments}: status {done.returncode}\n{done.stderr}")
    return done.stdout


def machine() -> dict:
    """What the last bits of a number hang on: compiler, libm, fused multiply-add."""
    compiler = subprocess.run([os.environ.get("CXX", "c++"), "--version"], check=True, text=True,
                              capture_output=True).stdout.splitlines()[0]
    flags = set(re.search(r"^flags\s*:(.*)$", Path("/proc/cpuinfo").read_text(),
                          re.MULTILINE).group(1).split())
    return {"compiler": compiler, "libc": " ".join(os.confstr("CS_GNU_LIBC_VERSION").split()),
            "x86-64-v3": {"avx2", "bmi1", "bmi2", "f16c", "fma", "movbe"} <= flags}


def simulate(output: Path, duration: float) -> None:
    program("simulate", "--config", CONFIG / "paper_simulation.yaml", "--set",
            "control/compensation=true", "--duration", duration, "--raw", "--output", output)


def fix(output: Path) -> None:
    """The kept bag with the messages of today."""
    done = subprocess.run(["rosbag", "fix", str(KEPT / "run.bag"), str(output)], check=False,
                          text=True, stdin=subprocess.DEVNULL, capture_output=True)
    if done.returncode != 0 or "Bag migrated successfully." not in done.stdout:
        raise AssertionError(f"rosbag fix: {done.stdout}{done.stderr}")


def identify(bag: Path, output: Path) -> None:
    """What tells when and where it was done is left out."""
    program("identify", bag, "--config", CONFIG / "paper_simulation.yaml", "--json", output)
    report = json.loads(output.read_text())
    del report["version"], report["runs"][0]["bags"]
    output.write_text(json.dumps(report, indent=1) + "\n")


def calibrate(output: Path) -> None:
    program("calibrate", "--config", TESTS / "short_calibration.yaml", "--output", output)


def contents_digests(bag: Path) -> dict:
    """SHA-256 by topic of the contents of the messages in their order. The sequence number in a
    header, the first four bytes, belongs to the transport."""
    digests = {}
    with rosbag.Bag(str(bag)) as opened:
        for topic, message, _ in opened.read_messages(raw=True):
            digests.setdefault(topic.lstrip("/"), hashlib.sha256()).update(message[1][4:])
    return {topic: digest.hexdigest() for topic, digest in sorted(digests.items())}


def locked_at(bag: Path):
    with rosbag.Bag(str(bag)) as opened:
        for _, message, time in opened.read_messages(topics=["orbital_elements",
                                                             "/orbital_elements"]):
            status = message.status
            if status.amplitude_locked and status.quadrature_locked and status.phase_locked:
                return time.to_sec()
    raise AssertionError("never locked")


def cut(source: Path, target: Path) -> None:
    """Up to five seconds after lock, with the raw samples of the first half second of those."""
    lock = locked_at(source)
    with rosbag.Bag(str(source)) as whole, rosbag.Bag(str(target), "w", compression="lz4") as kept:
        for topic, message, time in whole.read_messages():
            after = time.to_sec() - lock
            name = topic.lstrip("/")
            if name != "end_of_run" and after > AFTER_LOCK:
                continue
            if name in RAW and not 0.0 <= after < RAW_AFTER_LOCK:
                continue
            kept.write(topic, message, time)


def numbers(value, name: str, into: dict) -> dict:
    """Every number of a message by the name of its field."""
    if hasattr(value, "to_nsec"):
        into[name] = value.to_nsec()
    elif hasattr(value, "__slots__"):
        for slot in value.__slots__:
            if slot != "seq":
                numbers(getattr(value, slot), f"{name}.{slot}", into)
    elif isinstance(value, (list, tuple, bytes)):
        for index, element in enumerate(value):
            numbers(element, f"{name}[{index}]", into)
    elif isinstance(value, (bool, int, float)):
        into[name] = value
    return into


def signals(bag: Path, wanted=None) -> dict:
    """By topic and stamp, all but estimates and what is decided by them; with `wanted` only
    those."""
    found = {}
    with rosbag.Bag(str(bag)) as opened:
        for topic, message, time in opened.read_messages(raw=True):
            name, content, message_type = topic.lstrip("/"), message[1], message[4]
            key = name, time.to_nsec()
            if name in ("parameter_estimate", "compensation_gains", "end_of_run"):
                continue
            if wanted is None or key in wanted:
                found[key] = numbers(message_type().deserialize(content), "", {})
    return found


def record(commit: str, keep_bag: bool) -> None:
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        simulate(folder / "long.bag", LONG_RUN)
        if not keep_bag:
            cut(folder / "long.bag", KEPT / "run.bag")
        fix(folder / "run.bag")
        if not keep_bag:
            identify(folder / "run.bag", KEPT / "identify.json")
        identify(folder / "run.bag", folder / "identify.json")
        calibrate(KEPT / "calibration.yaml")
        digests = {"commit": commit, "machine": machine(),
                   "simulate": contents_digests(folder / "long.bag"),
                   "identify": sha256(folder / "identify.json")}
        (KEPT / "digests.json").write_text(json.dumps(digests, indent=1) + "\n")


def sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


class Baseline(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.folder = Path(cls.scratch.name)
        cls.digests = json.loads((KEPT / "digests.json").read_text())
        simulate(cls.folder / "long.bag", LONG_RUN)
        fix(cls.folder / "run.bag")
        identify(cls.folder / "run.bag", cls.folder / "identify.json")
        calibrate(cls.folder / "calibration.yaml")

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    def require_same_machine(self):
        here = machine()
        if here != self.digests["machine"]:
            self.skipTest(f"bits were recorded on {self.digests['machine']}, this is {here}")

    def test_simulation_has_the_same_bits(self):
        self.require_same_machine()
        self.assertEqual(contents_digests(self.folder / "long.bag"), self.digests["simulate"])

    def test_identification_has_the_same_bits(self):
        self.require_same_machine()
        self.assertEqual(sha256(self.folder / "identify.json"), self.digests["identify"],
                         (self.folder / "identify.json").read_text())

    def test_calibration_has_the_same_bits(self):
        self.require_same_machine()
        self.assertEqual((self.folder / "calibration.yaml").read_text(),
                         (KEPT / "calibration.yaml").read_text())

    def test_signals_are_the_same_but_for_rounding(self):
        kept = signals(self.folder / "run.bag")
        found = signals(self.folder / "long.bag", kept)
        self.assertGreater(len(kept), 3 * 1000 * AFTER_LOCK)
        for key, values in kept.items():
            self.assertIn(key, found)
            now = found[key]  # fields may have been added
            if not all(math.isclose(now[name], value, rel_tol=ROUNDING, abs_tol=ROUNDING)
                       for name, value in values.items()):
                self.fail(f"{key}: {now} instead of {values}")

    def test_estimates_are_within_a_thousandth_of_a_sigma(self):
        now, then = (json.loads(path.read_text())["runs"][0]
                     for path in (self.folder / "identify.json", KEPT / "identify.json"))
        self.assertEqual(set(now["parameters"]), set(then["parameters"]))
        for name, kept in then["parameters"].items():
            found = now["parameters"][name]
            self.assertLessEqual(abs(found["sigma"] / kept["sigma"] - 1.0), SIGMA, name)
            self.assertLessEqual(abs(found["value"] - kept["value"]) / kept["sigma"],
                                 VALUE_IN_SIGMA, name)


if __name__ == "__main__":
    if "--record" in sys.argv:
        record(sys.argv[sys.argv.index("--record") + 1], "--keep-bag" in sys.argv)
    else:
        sys.exit(junit.main(sys.argv[3:]))
