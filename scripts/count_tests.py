#!/usr/bin/python3
"""Sums JUnit result files: prints each failure and, last, 'N passed, N failed'.

usage: count_tests.py RESULTS... (files or folders); exit status 1 when a test failed or none ran.
A result file that cannot be read counts as a failure.
"""

import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path


def result_files(arguments: list) -> list:
    files = []
    for argument in map(Path, arguments):
        files += sorted(argument.rglob("*.xml")) if argument.is_dir() else [argument]
    return files


def count(path: Path) -> tuple:
    """(passed, failed, skipped) of one file."""
    try:
        root = ElementTree.parse(path).getroot()
    except (ElementTree.ParseError, OSError) as error:
        print(f"FAILED {path}: {error}")
        return 0, 1, 0
    passed = failed = skipped = 0
    for case in root.iter("testcase"):
        name = f"{case.get('classname', path.stem)}.{case.get('name')}"
        problems = case.findall("failure") + case.findall("error")
        if problems:
            failed += 1
            text = (problems[0].get("message") or problems[0].text or "").strip()
            first = text.splitlines()[0] if text else ""
            print(f"FAILED {path.stem}: {name}: {first}")
        elif case.find("skipped") is not None or case.get("status") == "notrun":
            skipped += 1
        else:
            passed += 1
    if failed == 0:  # a suite that failed outside of its cases
        extra = sum(int(root.get(key) or 0) for key in ("errors", "failures"))
        if extra:
            print(f"FAILED {path}: {extra} errors outside of the test cases")
            failed += extra
    return passed, failed, skipped


def main() -> int:
    counts = [count(path) for path in result_files(sys.argv[1:])]
    passed, failed, skipped = (sum(column) for column in zip(*counts)) if counts else (0, 0, 0)
    print(f"{passed} passed, {failed} failed" + (f", {skipped} skipped" if skipped else ""))
    return 1 if failed or not passed else 0


if __name__ == "__main__":
    sys.exit(main())
