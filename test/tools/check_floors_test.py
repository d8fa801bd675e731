#!/usr/bin/python3
"""scripts/check_floors.py finds a wrong include and names it.

usage: check_floors_test.py PACKAGE [RESULT.xml]
"""

import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import junit  # noqa: E402

PACKAGE = Path(sys.argv[1])

# File, an include in its second line, why it is wrong; no reason: it is right.
CASES = [
    ("src/common/angle.cpp", '"ring_gyro/control/loop_filter.h"', "control does not stand beneath common"),
    ("src/signals/time_guard.cpp", '"ring_gyro/resonator/converter.h"',
     "resonator does not stand beneath signals"),
    ("include/ring_gyro/identification/model/averaged_model.h",
     '"ring_gyro/identification/filter/identifier.h"',
     "identification/filter does not stand beneath identification/model"),
    ("src/identification/filter/identifier.cpp", '"ring_gyro/identification/judge/consistency.h"',
     "identification/judge does not stand beneath identification/filter"),
    ("src/control/control_loops.cpp", "<ros/ros.h>", "ros may be used from the floor ros upwards"),
    ("src/signals/orbit.cpp", '"ring_gyro/OrbitalElements.h"', "a ROS message"),
    ("src/logs/csv_source.cpp", "<nlohmann/json.hpp>", ""),
    ("src/simulation/closed_loop.cpp", "<yaml-cpp/yaml.h>", "from the floor configuration upwards"),
    ("src/nodes/output.cpp", '"ring_gyro/tools/line_file.h"', "tools does not stand beneath nodes"),
    ("src/garage/car.cpp", "<vector>", "stands in no floor"),
    ("src/control/loop.hpp", '"ring_gyro/nodes/output.h"', "nodes does not stand beneath control"),
    ("src/tools/identify.cpp", '"../nodes/node_main.h"', "name it from ring_gyro/ on"),
    ("src/common/angle.cpp", "<matio.h>", "may be used from the floor logs upwards"),
    ("src/logs/mat_source.cpp", "<matio.h>", ""),
    ("src/control/control_loops.cpp", '"ring_gyro/garage/car.h"', "garage is no floor"),
    ("src/control/control_loops.cpp", '"ring_gyro/signals/control_gains.h"', ""),
    ("src/identification/judge/consistency.cpp", '"ring_gyro/identification/model/averaged_model.h"', ""),
    ("src/nodes/output.cpp", '"ring_gyro/OrbitalElements.h"', ""),
]


def check(package: Path):
    return subprocess.run([str(PACKAGE / "scripts" / "check_floors.py"), str(package)], check=False,
                          text=True, capture_output=True)


class CheckFloors(unittest.TestCase):
    def test_names_each_wrong_include_and_no_right_one(self):
        for name, header, why in CASES:
            with self.subTest(file=name, include=header), tempfile.TemporaryDirectory() as scratch:
                file = Path(scratch) / name
                file.parent.mkdir(parents=True)
                file.write_text(f"// A file.\n#include {header}\n")
                done = check(Path(scratch))
                self.assertEqual(done.returncode, 1 if why else 0, done.stdout)
                self.assertIn(why, done.stdout)
                if why and "stands in no floor" not in why:
                    self.assertIn(f"{name}:2: includes", done.stdout)

    def test_an_empty_package_is_a_fault(self):
        with tempfile.TemporaryDirectory() as scratch:
            self.assertEqual(check(Path(scratch)).returncode, 1)

    def test_this_package_is_right(self):
        done = check(PACKAGE)
        self.assertEqual(done.returncode, 0, done.stdout)


class Architecture(unittest.TestCase):
    """The page says what there is."""

    def setUp(self):
        self.page = (PACKAGE / "docs" / "architecture.md").read_text()

    def test_each_stop_of_the_walk_is_there_and_none_twice(self):
        stops = re.findall(r"^\| `([\w/]+\.(?:h|cpp))`, `([\w:]+)` \|", self.page, re.MULTILINE)
        self.assertGreater(len(stops), 20)
        self.assertEqual(len(stops), len({file for file, _ in stops}))
        for file, name in stops:
            with self.subTest(file=file, name=name):
                places = [PACKAGE / "src" / file, PACKAGE / "include" / "ring_gyro" / file]
                texts = [place.read_text() for place in places if place.exists()]
                self.assertTrue(any(re.search(rf"\b{name}\b", text) for text in texts))

    def test_each_floor_is_in_its_table(self):
        for base in (PACKAGE / "src", PACKAGE / "include" / "ring_gyro"):
            for folder in {file.parent.relative_to(base) for file in base.rglob("*.h")}:
                self.assertIn(f"`{folder.as_posix()}`", self.page)


if __name__ == "__main__":
    sys.exit(junit.main(sys.argv[2:]))
