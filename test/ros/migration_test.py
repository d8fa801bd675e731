#!/usr/bin/python3
"""Bags of every age: rosbag fix brings them up to date, and until then the tools refuse them with
the command to run.

usage: migration_test.py FOLDER_OF_PROGRAMS CONFIG_FOLDER [RESULT.xml]
"""

import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import genpy
import genpy.dynamic
import ring_gyro.msg
import rosbag
from rosbag.migration import MessageUpdateRule

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import junit  # noqa: E402

PROGRAMS, CONFIG = Path(sys.argv[1]), Path(sys.argv[2]) / "paper_simulation.yaml"
PACKAGE = Path(__file__).resolve().parent.parent.parent
RULES = PACKAGE / "ring_gyro_migration" / "messages.bmr"
OLD_RUN = PACKAGE / "test" / "baseline" / "run.bag"
OLD_CALIBRATION = PACKAGE / "test" / "baseline" / "calibration_run.bag"

# Checksums of every definition that has ever been recorded, oldest first.
AGES = {
    "Calibration": ["570405980f7dcec285b9324c1268cc80", "7efa9ad65451e2c7b179acd116063dd5",
                    "d3f327456a1ba42b7017e4536bdc4183"],
    "CalibrationCommand": ["94b665bbb6e4d06889d07627b295510f", "5047c51f03b481aafc4c9d043241b8d5",
                           "f91637804c027f1ee62b2f593c906e9c"],
    "CompensationGains": ["98f04ae2effef4f217bf84d7bd04895b", "006451cdc7e2397ccc2ef8245cf27f98"],
    "ControlGains": ["2943782fc087af0c17b0f87c3106a5cf", "e4353103a2eed13e01f282324313c9d4"],
    "DisplacementBlock": ["06a9cd50d96bd54d7aa033cfcca4b063", "60c7c317f41f752686373f5de8979e16"],
    "DriveCommand": ["5179d6813b0df32aa715f4fe23c75bb3", "2cf0b89f607b3d863e86b346a9ca4855",
                     "dab6c1be300fc72345a02cb0086689a9"],
    "EndOfRun": ["c61aee1d26b2950fe496e1b033324e41"],
    "Envelope": ["5e757e7d75b362b4778165faad0bec9f"],
    "LoopStatus": ["37e81603379724155c25b64ed06c4223"],
    "OrbitalElements": ["f126c805adc47818c189297215db5011", "655348a76d7dbbe205a8e98ce0442955"],
    "ParameterEstimate": ["3a622ff0b2bed3787b91524cfccd7ab6", "f6eb6882612068fe74505fb8cc708eac"],
    "PlantTruth": ["23e895f5681f3ba0db056de919d80132", "d01b11d5be17bdd28a2c627c06784ad3"],
}
# What a field is that its bag does not have, by the fields that it has.
ADDED = {
    "CalibrationCommand": {"calibration.drive_rotation": lambda old: 0.0,
                           "calibration.rotation_phase": lambda old: 0.0},
    "Calibration": {"drive_rotation": lambda old: 0.0, "rotation_phase": lambda old: 0.0},
    "DisplacementBlock": {"clipped_drive_samples": lambda old: 0},
    "DriveCommand": {"table_rate": lambda old: 0.0, "end_of_run": lambda old: False},
    "OrbitalElements": {"angle": lambda old: old["theta"],
                        "angle_rate": lambda old: old["theta_rate"]},
}
COMMAND = """std_msgs/Header header
uint32 session
uint64 effective_sequence
uint64 data_sequence
float64 virtual_rate
float64 table_rate
float64 amplitude_modulation
float64 amplitude_modulation_frequency
bool end_of_run
Calibration calibration
string leg
float64 time_left
bool finished
string failure
"""
TOOLS = ("identify", "compare_identifiers", "summarise_run", "validate_bag", "export_csv")


def definitions() -> dict:
    """Message classes by name and age, from the texts that the rules begin with."""
    read = {"MessageUpdateRule": MessageUpdateRule}
    exec(RULES.read_text(), read)
    texts = {(rule.old_type[len("ring_gyro/"):], rule.order): rule.old_full_text
             for rule in read.values()
             if isinstance(rule, type) and rule is not MessageUpdateRule}
    parting = "\n" + "=" * 80 + "\n"
    for age in (1, 2):
        texts["CalibrationCommand", age] = parting.join(
            (COMMAND, read["HEADER"], "MSG: ring_gyro/Calibration\n" + texts["Calibration", age]))
    return {(name, age): genpy.dynamic.generate_dynamic(f"ring_gyro/{name}", text)
            [f"ring_gyro/{name}"] for (name, age), text in texts.items()}


class Filler:
    """A value for each field, none like another."""

    def __init__(self):
        self.count = 0

    def fill(self, message):
        for name, kind in zip(message.__slots__, message._slot_types):
            setattr(message, name, self.value(getattr(message, name), kind))
        return message

    def value(self, default, kind):
        self.count += 1
        if kind.endswith("[]"):
            return [self.value(0.0, kind[:-2]) for _ in range(3)]
        if kind.endswith("]"):
            return [self.value(element, kind[:kind.index("[")]) for element in default]
        if kind == "bool":
            return self.count % 3 != 0
        if kind == "string":
            return f"text {self.count}"
        if kind == "time":
            return genpy.Time(self.count, self.count)
        if kind.startswith("float"):
            return self.count + 1.0 / 3.0
        if kind.startswith(("int", "uint")):
            return self.count % 100
        return self.fill(default)


def values(message, prefix="", into=None) -> dict:
    """By the name of the field, those of messages within it too."""
    into = {} if into is None else into
    for name in message.__slots__:
        value = getattr(message, name)
        if hasattr(value, "_slot_types"):
            values(value, f"{prefix}{name}.", into)
        else:
            into[prefix + name] = list(value) if isinstance(value, (list, tuple)) else value
    return into


def today(old: dict, name: str) -> dict:
    """What a message of some age is now."""
    new = {re.sub(r"((?:gamma|mu|gain))_([12])$", r"\1\2", field): value
           for field, value in old.items()}
    for field, rule in ADDED.get(name, {}).items():
        new.setdefault(field, rule(old))
    return new


def run(*command) -> subprocess.CompletedProcess:
    return subprocess.run([*map(str, command)], stdin=subprocess.DEVNULL, capture_output=True,
                          text=True, timeout=300, check=False)


class Migration(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.classes = definitions()

    def setUp(self):
        self.scratch = tempfile.TemporaryDirectory(prefix="ring gyro's bags ")
        self.addCleanup(self.scratch.cleanup)
        self.folder = Path(self.scratch.name)

    def succeed(self, *command) -> str:
        done = run(*command)
        self.assertEqual(done.returncode, 0, f"{command}: {done.stdout}{done.stderr}")
        return done.stdout

    def fix(self, old: Path, new: Path) -> None:
        said = self.succeed("rosbag", "fix", old, new)
        self.assertIn("Bag migrated successfully.", said)
        self.assertNotIn("WARNING", said)

    def test_a_changed_message_needs_a_rule(self):
        names = {name for name in dir(ring_gyro.msg)
                 if isinstance(getattr(ring_gyro.msg, name), type)}
        self.assertEqual(names, set(AGES), "give each message its checksum in AGES")
        for name, ages in AGES.items():
            self.assertEqual(
                getattr(ring_gyro.msg, name)._md5sum, ages[-1],
                f"{name} has changed: bags of today would be lost. Append its definition and a "
                f"rule to {RULES.relative_to(PACKAGE)}, then its checksum (and that of each "
                f"message that holds it) to AGES")

    def test_rules_start_from_what_was_recorded(self):
        old = {(name, age): checksum for name, ages in AGES.items()
               for age, checksum in enumerate(ages[:-1], 1)}
        self.assertEqual({key: found._md5sum for key, found in self.classes.items()}, old)

    def test_each_age_is_converted(self):
        """In every compression; values, bag times and topics."""
        for age in sorted({age for _, age in self.classes}):
            for compression in ("none", "bz2", "lz4"):
                old = self.folder / f"{compression} {age}.bag"
                new = self.folder / f"{compression} {age} now.bag"
                recorded = {}
                filler = Filler()
                with rosbag.Bag(str(old), "w", compression=compression) as bag:
                    for (name, its_age), kind in self.classes.items():
                        if its_age != age:
                            continue
                        for copy in range(3):
                            time = genpy.Time(100 + copy, filler.count)
                            message = filler.fill(kind())
                            bag.write(f"/gyro/{name}", message, time)
                            recorded[name, time.to_nsec()] = today(values(message), name)
                self.assertGreaterEqual(len(recorded), 3)
                self.assertIn("All rules defined", self.succeed("rosbag", "check", old))
                self.fix(old, new)
                self.assertIn("does not need any", self.succeed("rosbag", "check", new))
                found = {}
                with rosbag.Bag(str(new)) as bag:
                    for topic, (kind, content, md5, _, _), time in bag.read_messages(raw=True):
                        name = topic[len("/gyro/"):]
                        self.assertEqual((kind, md5), (f"ring_gyro/{name}", AGES[name][-1]))
                        message = getattr(ring_gyro.msg, name)().deserialize(content)
                        found[name, time.to_nsec()] = values(message)
                self.assertEqual(found, recorded)

    def test_a_recorded_calibration_is_converted(self):
        def contents(bag, change):
            with rosbag.Bag(str(bag)) as opened:
                return [(topic, time.to_nsec(), change(values(message), message._type))
                        for topic, message, time in opened.read_messages()]
        new = self.folder / "calibration.bag"
        self.fix(OLD_CALIBRATION, new)
        then = contents(OLD_CALIBRATION, lambda old, kind: today(old, kind.split("/")[1]))
        self.assertEqual(contents(new, lambda found, kind: found), then)
        self.assertTrue(any(found.get("calibration.gamma1", 0.0) != 0.0 for _, _, found in then))

    def outcome(self, tool: str, bag: Path) -> subprocess.CompletedProcess:
        (self.folder / "result").unlink(missing_ok=True)
        more = {"identify": ("--config", CONFIG, "--json", self.folder / "result"),
                "compare_identifiers": ("--config", CONFIG),
                "export_csv": ("--output", self.folder / "result")}
        return run(PROGRAMS / tool, bag, *more.get(tool, ()))

    def command_of(self, tool: str, bag: Path, name: str, md5: str) -> str:
        """What the tool asks for; it has refused the bag in one line."""
        done = self.outcome(tool, bag)
        self.assertEqual(done.returncode, 2 if tool == "validate_bag" else 1, done.stdout)
        self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
        self.assertFalse((self.folder / "result").exists())
        for part in (f"{bag}: topic ", f" ring_gyro/{name} of another version", md5):
            self.assertIn(part, done.stderr, tool)
        return done.stderr.strip().split("; convert the bag: ")[1]

    def test_tools_refuse_an_old_bag_and_say_how_to_convert_it(self):
        old = self.folder / "an old run.bag"
        shutil.copy(OLD_RUN, old)
        new = self.folder / "an old run_fixed.bag"
        commands = {tool: self.command_of(tool, old, "ControlGains", AGES["ControlGains"][0])
                    for tool in TOOLS}
        for tool, command in commands.items():
            self.assertEqual(shlex.split(command), ["rosbag", "fix", str(old), str(new)], tool)
        self.succeed("bash", "-c", commands["identify"])
        for tool in TOOLS:
            done = self.outcome(tool, new)
            self.assertIn(done.returncode, (0, 1) if tool == "validate_bag" else (0,),
                          f"{tool}: {done.stdout}{done.stderr}")
            self.assertNotIn("another version", done.stderr)
        # What is there is not to be replaced.
        again = self.command_of("identify", old, "ControlGains", AGES["ControlGains"][0])
        self.assertEqual(shlex.split(again)[-1], str(self.folder / "an old run_fixed2.bag"))

    def test_whatever_a_tool_reads_must_be_of_today(self):
        """The elements and gains are; another message that the tool reads is not."""
        fresh = self.folder / "fresh.bag"
        self.fix(OLD_RUN, fresh)
        ahead = genpy.dynamic.generate_dynamic(
            "ring_gyro/EndOfRun", "uint32 session\nuint64 last_sequence\nbool more\n")
        others = {"EndOfRun": (ahead["ring_gyro/EndOfRun"], ("summarise_run", "validate_bag")),
                  "PlantTruth": (self.classes["PlantTruth", 1],
                                 ("summarise_run", "compare_identifiers")),
                  "ParameterEstimate": (self.classes["ParameterEstimate", 1], ("summarise_run",))}
        for name, (kind, readers) in others.items():
            mixed = self.folder / f"old {name}.bag"
            with rosbag.Bag(str(fresh)) as whole, rosbag.Bag(str(mixed), "w") as bag:
                for topic, message, time in whole.read_messages(
                        topics=["orbital_elements", "control_gains"], raw=True):
                    bag.write(topic, message, time, raw=True)
                bag.write(name, Filler().fill(kind()), time)
            for tool in readers:
                command = self.command_of(tool, mixed, name, kind._md5sum)
                self.assertTrue(command.startswith("rosbag fix "), command)
        # Of what it does not read, it asks nothing.
        done = self.outcome("identify", mixed)
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_an_old_bag_without_an_index_gets_one_first(self):
        killed = self.folder / "killed.bag"
        kind = self.classes["OrbitalElements", 1]
        with rosbag.Bag(str(self.folder / "whole.bag"), "w", chunk_threshold=1) as bag:
            for second in range(3):
                bag.write("orbital_elements", Filler().fill(kind()), genpy.Time(1 + second))
            bag.flush()
            shutil.copy(self.folder / "whole.bag", killed)
        command = self.command_of("identify", killed, "OrbitalElements",
                                  AGES["OrbitalElements"][0])
        self.succeed("bash", "-c", command)
        with rosbag.Bag(str(self.folder / "killed_fixed.bag")) as bag:
            self.assertEqual(bag.get_message_count(), 2)  # those of the chunks that are whole


if __name__ == "__main__":
    sys.exit(junit.main(sys.argv[3:]))
