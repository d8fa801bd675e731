"""The package's C++ programs, run from Python, and what they leave behind."""

import csv
import json
import os
import subprocess
import sys
import threading
import time
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from pathlib import Path

import numpy as np


class ToolError(Exception):
    """One line: what failed, why, the mend."""


def find_tool(name: str) -> str:
    """The program of this package beside the running one, or where catkin knows it."""
    beside = Path(sys.argv[0]).resolve().parent / name
    if os.access(beside, os.X_OK) and beside.is_file():
        return str(beside)
    try:
        found = subprocess.run(["catkin_find", "--first-only", "--libexec", "ring_gyro", name],
                               capture_output=True, text=True, check=False).stdout.strip()
    except OSError:
        found = ""
    if not found:
        raise ToolError(f"the program {name} of ring_gyro is not found: build the package and "
                        "source devel/setup.bash")
    return found


def find_config(name: str) -> Path:
    """A preset of the package."""
    candidates = [Path(__file__).resolve().parents[2] / "config"]
    try:
        found = subprocess.run(["rospack", "find", "ring_gyro"], capture_output=True, text=True,
                               check=False).stdout.strip()
    except OSError:
        found = ""
    if found:
        candidates.insert(0, Path(found) / "config")
    for folder in candidates:
        if (folder / name).is_file():
            return folder / name
    raise ToolError(f"the preset {name} is not found in {candidates[0]}: install the package's "
                    "config folder or source devel/setup.bash")


def run_tool(name: str, *arguments, allowed=(0,)) -> str:
    """Its standard output; ToolError with its last line of complaint when its status is none of
    `allowed`."""
    command = [find_tool(name), *map(str, arguments)]
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True,
                          check=False)
    if done.returncode not in allowed:
        lines = done.stderr.strip().splitlines() or [f"ended with status {done.returncode}"]
        reason = lines[-1]
        raise ToolError(reason if reason.startswith(name + ":") else f"{name}: {reason}")
    return done.stdout


class Series:
    """Columns of a CSV file by name; an empty cell is NaN."""

    def __init__(self, path: Path):
        with path.open(newline="") as file:
            self.names = next(csv.reader([file.readline()]))
            rows = [[float(cell) if cell else np.nan for cell in row] for row in csv.reader(file)]
        table = np.array(rows, dtype=float).reshape(len(rows), len(self.names))
        self._columns = {name: table[:, i] for i, name in enumerate(self.names)}

    def __getitem__(self, name: str) -> np.ndarray:
        return self._columns[name]

    def __len__(self) -> int:
        return len(self._columns[self.names[0]])


class Run:
    """What summarise_run said of a bag: `summary` and the series."""

    def __init__(self, folder: Path):
        self.folder = folder
        self.summary = json.loads((folder / "summary.json").read_text())
        self._series = {}

    def series(self, name: str) -> Series:
        if name not in self._series:
            self._series[name] = Series(self.folder / f"{name}.csv")
        return self._series[name]

    @property
    def drift(self) -> dict:
        """Of the compensated stretch when there is one, or else without compensation."""
        after = self.summary["drift_after"]
        return self.summary["drift_before"] if "missing" in after else after


def summarise(bag: Path, folder: Path) -> Run:
    folder.mkdir(parents=True, exist_ok=True)
    # With status 2 there is a summary whose identification does not fit the data: it says so itself.
    text = run_tool("summarise_run", bag, "--json", folder / "summary.json", "--csv", folder,
                    allowed=(0, 2))
    run = Run(folder)
    run.text = text
    return run


def simulate(config: Path, folder: Path, duration: float, overrides: dict, keep: bool) -> Run:
    """Simulates, summarises, and drops the bag unless it is to be kept."""
    folder.mkdir(parents=True, exist_ok=True)
    bag = folder / "run.bag"
    settings = [f"--set={key}={value}" for key, value in overrides.items()]
    run_tool("simulate", "--config", config, "--output", bag, "--duration", repr(float(duration)),
             *settings)
    run = summarise(bag, folder)
    if not keep:
        bag.unlink()
    return run


class Progress:
    """A bar on a terminal; elsewhere a line now and then."""

    WIDTH = 32
    QUIET = 15.0  # seconds between lines where there is no terminal

    def __init__(self, total: int):
        self.total = total
        self.done = 0
        self._started = time.monotonic()
        self._said = self._started
        self._terminal = sys.stderr.isatty()
        self._lock = threading.Lock()

    def step(self, what: str) -> None:
        with self._lock:
            self.done += 1
            self._say(what)

    def _say(self, what: str) -> None:
        elapsed = time.monotonic() - self._started
        if self._terminal:
            filled = self.WIDTH * self.done // max(self.total, 1)
            bar = "#" * filled + "." * (self.WIDTH - filled)
            print(f"\r\033[K[{bar}] {self.done}/{self.total} {elapsed:.0f} s  {what}", end="",
                  file=sys.stderr, flush=True)
        elif self.done == self.total or time.monotonic() - self._said > self.QUIET:
            self._said = time.monotonic()
            print(f"{self.done} of {self.total} done after {elapsed:.0f} s: {what}",
                  file=sys.stderr, flush=True)

    def clear(self) -> None:
        if self._terminal:
            print("\r\033[K", end="", file=sys.stderr, flush=True)


def run_jobs(jobs: dict, workers: int, progress: Progress) -> dict:
    """jobs: name to callable. Results by name; the first failure ends it all and is raised."""
    results = {}
    with ThreadPoolExecutor(workers) as pool:
        waiting = {pool.submit(job): name for name, job in jobs.items()}
        while waiting:
            finished, _ = wait(waiting, return_when=FIRST_COMPLETED)
            for future in finished:
                name = waiting.pop(future)
                if future.exception() is not None:
                    for other in waiting:
                        other.cancel()
                    raise future.exception()
                results[name] = future.result()
                progress.step(name)
    return results
