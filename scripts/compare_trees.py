#!/usr/bin/python3
"""What a change did to the house: lines by folder and test cases, before and after.

usage: compare_trees.py BEFORE [AFTER]      (commits; AFTER: HEAD)

A test case is known by its name alone, so that one that only moved to another file is not lost.
"""

import re
import subprocess
import sys
from collections import Counter

CASE = [(re.compile(r"\.cpp$"), re.compile(r"^(?:TYPED_)?TEST(?:_F|_P)?\(\s*(\w+),\s*(\w+)\)", re.M)),
        (re.compile(r"\.py$"), re.compile(r"^()    def (test_\w+)\(", re.M))]


def git(*arguments: str) -> str:
    return subprocess.run(["git", *arguments], check=True, text=True, errors="replace",
                          capture_output=True).stdout


def folder_of(path: str) -> str:
    """src/control and include/ring_gyro/control are one folder, with the shelves of each."""
    parts = path.split("/")[:-1]
    if parts[:1] == ["src"]:
        parts = parts[1:]
    elif parts[:2] == ["include", "ring_gyro"]:
        parts = parts[2:]
    else:
        return parts[0] if parts else ""
    return "code: " + "/".join(parts)


def tree(commit: str):
    lines, cases = Counter(), {}
    for path in git("ls-tree", "-r", "--name-only", commit).split("\n"):
        if not re.search(r"\.(h|cpp|py|sh|m|msg|bmr|launch|test|yaml|md)$|^python/", path):
            continue
        text = git("show", f"{commit}:{path}")
        lines[folder_of(path)] += text.count("\n")
        if path.startswith("test/"):
            for suffix, pattern in CASE:
                if suffix.search(path):
                    for group, name in pattern.findall(text):
                        cases[f"{group}.{name}" if group else name] = path
    return lines, cases


def main() -> int:
    if not 2 <= len(sys.argv) <= 3:
        print(__doc__, file=sys.stderr)
        return 2
    before, after = sys.argv[1], (sys.argv + ["HEAD"])[2]
    (lines_before, cases_before), (lines_after, cases_after) = tree(before), tree(after)
    for folder in sorted(set(lines_before) | set(lines_after)):
        print(f"{folder:32} {lines_before[folder]:7} {lines_after[folder]:7}")
    for which in ("code: ", ""):
        total = [sum(n for f, n in lines.items() if f.startswith(which))
                 for lines in (lines_before, lines_after)]
        print(f"{'all' if not which else 'src and include':32} {total[0]:7} {total[1]:7}")
    common = set(cases_before) & set(cases_after)
    moved = sum(cases_before[name] != cases_after[name] for name in common)
    print(f"test cases: {len(cases_before)} before, {len(cases_after)} after, {moved} in another file")
    for title, names in (("gone", set(cases_before) - common), ("new", set(cases_after) - common)):
        print(f"{title}: {len(names)}")
        for name in sorted(names):
            print(f"  {name:70} { {**cases_before, **cases_after}[name]}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
