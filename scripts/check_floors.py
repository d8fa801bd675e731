#!/usr/bin/python3
"""Checks that every folder of the package includes only what stands beneath it.

The folders of include/ring_gyro and src are floors, lowest first, and the shelves of a folder are
floors too; nodes and tools stand side by side on top. Below the ros floor nothing may include ROS,
and each outside library has the lowest floor that may use it.

usage: check_floors.py [PACKAGE]
"""

import re
import sys
from pathlib import Path

FLOORS = [
    "common", "signals", "resonator", "demodulation", "control", "identification/model",
    "identification/filter", "identification/judge", "compensation", "analysis", "calibration",
    "simulation", "configuration", "logs", "ros", "nodes", "tools",
]
LEVEL = {name: level for level, name in enumerate(FLOORS)}
LEVEL["tools"] = LEVEL["nodes"]

# Lowest floor that may include headers from these folders; any other folder is ROS.
OUTSIDE = {"Eigen": "common", "boost": "common", "yaml-cpp": "configuration",
           "nlohmann": "configuration", "unsupported": "common", "sys": "common"}

# The same for libraries whose headers stand in no folder; others are of the system.
OUTSIDE_HEADERS = {"matio.h": "logs", "hdf5.h": "logs", "zlib.h": "logs", "bzlib.h": "ros"}

SOURCES = {".h", ".hh", ".hpp", ".hxx", ".inl", ".ipp", ".c", ".cc", ".cpp", ".cxx"}
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')


def floor_of(folder: str) -> str:
    """Of the files in this folder; empty when it is none."""
    parts = folder.split("/")
    for depth in (2, 1):
        name = "/".join(parts[:depth])
        if name in LEVEL:
            return name
    return ""


def fault(floor: str, header: str) -> str:
    """Why a file of `floor` must not include `header`; empty when it may."""
    parts = header.split("/")
    if parts[0] == "ring_gyro":
        if len(parts) == 2:  # a generated message
            return "" if LEVEL[floor] >= LEVEL["ros"] else "a ROS message"
        folder = "/".join(parts[1:-1])
        target = floor_of(folder)
        if not target:
            return f"the folder {folder} is no floor known to scripts/check_floors.py"
        if target == floor or LEVEL[target] < LEVEL[floor]:
            return ""
        return f"{target} does not stand beneath {floor}"
    if ".." in parts or "." in parts:
        return "name it from ring_gyro/ on"
    if len(parts) == 1 and header not in OUTSIDE_HEADERS:  # the system's, or beside the file
        return ""
    lowest = OUTSIDE_HEADERS.get(header) or OUTSIDE.get(parts[0], "ros")
    if LEVEL[floor] >= LEVEL[lowest]:
        return ""
    return f"{parts[0]} may be used from the floor {lowest} upwards"


def main() -> int:
    root = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).resolve().parent.parent)
    files = 0
    faults = []
    for base in (root / "include" / "ring_gyro", root / "src"):
        for path in sorted(base.rglob("*")):
            if path.suffix not in SOURCES:
                continue
            files += 1
            name = path.relative_to(root)
            floor = floor_of(path.relative_to(base).parent.as_posix())
            if not floor:
                faults.append(f"{name}:1: stands in no floor known to scripts/check_floors.py")
                continue
            for number, line in enumerate(path.read_text().splitlines(), 1):
                match = INCLUDE.match(line)
                if match and (why := fault(floor, match.group(2))):
                    faults.append(f"{name}:{number}: includes {match.group(2)}: {why}")
    if not files:
        faults.append(f"no source files under {root}")
    for line in faults:
        print(line)
    print(f"floors: {files} files, {len(faults)} faults")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
