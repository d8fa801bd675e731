#!/usr/bin/python3
"""Runs all measurements against their peers, prints the table and writes it into the docs.

    measure.py BIN_DIR [--quick] [--only ROW ...] [--output docs/performance.md]

Every figure is a median from one run in which our program and its peer alternate. Rows that need a
program that is not installed say so. Called by scripts/benchmark.sh.
"""

import argparse
import json
import os
import platform
import re
import shutil
import socket
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
CONFIG = ROOT / "config" / "paper_simulation.yaml"
BEGIN, END = "<!-- table: scripts/benchmark.sh -->", "<!-- end of the table -->"


class Row:
    """One line of the table. `most`: the goals are upper limits, not lower ones."""

    def __init__(self, what, peer, must, aim, unit="x", most=False):
        self.what, self.peer, self.must, self.aim = what, peer, must, aim
        self.unit, self.most = unit, most
        self.measured = None
        self.note = ""

    def verdict(self):
        if self.measured is None:
            return self.note or "not measured"
        reaches = (lambda goal: self.measured <= goal) if self.most else (lambda goal: self.measured >= goal)
        return "aim" if reaches(self.aim) else "must" if reaches(self.must) else "short"

    def cells(self):
        measured = "-" if self.measured is None else figure(self.measured) + self.unit
        if self.measured is not None and self.note:
            measured += f" ({self.note})"
        return [self.what, self.peer, figure(self.must) + self.unit, figure(self.aim) + self.unit,
                measured, self.verdict()]


def figure(value):
    if value == 0 or abs(value) < 1e-3:
        return f"{value:.1e}"
    return f"{value:.3g}" if abs(value) < 1000 else f"{value:.0f}"


def rows():
    lockstep = "a bare roscpp echo pair, same messages, same core"
    return {
        "filter_speed": Row("EKF predict + update (7 states), default build",
                            "the paper's filter, dense 7x7 Eigen matrices", 3, 7),
        "octave": Row("the same", "Octave script of the paper's loop", 500, 900),
        "filter_accuracy": Row("EKF accuracy, worst state", "long double, 300 000 steps", 1e-5, 1e-7,
                               " sigma", most=True),
        "plant": Row("plant, 1 ms blocks, everything changes each block",
                     "Boost.odeint fehlberg78, one step a sample", 30, 150),
        "closed_loop": Row("closed loop in process",
                           "RK4 at 114 steps a cycle, std::normal_distribution, std::sin/cos", 30, 130),
        "speed": Row("the same, one core", "real time", 150, 800),
        "chain_10Hz": Row("full chain with compensation, EKF at 10 Hz", "closed loop alone", 0.93, 0.98),
        "chain_1kHz": Row("full chain with compensation, EKF at 1 kHz", "closed loop alone", 0.83, 0.92),
        "lockstep": Row("lockstep plant and loops, processes", lockstep, 0.8, 0.95),
        "lockstep_full": Row("the same with identifier, injector, recorder", lockstep, 0.5, 0.7),
        "nodelets": Row("lockstep graph, nodelets", "the same graph as processes", 3, 5),
        "identify_wall": Row("`identify`, 300 s bag at 1 kHz, time", "bare rosbag::View read", 1.25,
                             1.05, most=True),
        "bag_order": Row("tools on a bag in bursts or by topic, processor time, the worst",
                         "the same bag in the order of time", 1.3, 1.05, most=True),
        "python": Row("`identify`", "Python rosbag and numpy doing the same", 30, 30),
        "monte_carlo": Row("Monte Carlo, 2 cores", "1 core, half on each", 1.9, 1.98),
        "memory": Row("memory of `identify` beyond a bare read, 300 s", "rosbag::View", 20, 5, " MB",
                      most=True),
        "memory_long": Row("the same, 3 h", "rosbag::View", 20, 5, " MB", most=True),
        "flat_cost": Row("cost of a simulated second after 3 h", "after 1 s", 0.95, 1.0),
    }


class Measurement:
    def __init__(self, programs, quick, work):
        self.programs, self.quick, self.work = programs, quick, work
        self.rows = rows()

    def say(self, text):
        print(text, file=sys.stderr, flush=True)

    def run(self, *command, **options):
        return subprocess.run([str(part) for part in command], check=True, text=True,
                              stdout=subprocess.PIPE, **options).stdout

    def benchmark(self, program, *arguments):
        """Counters of a Google Benchmark program, by the name of the benchmark."""
        text = self.run(self.programs / program, *arguments, "--benchmark_format=json",
                        stderr=subprocess.DEVNULL)
        return {entry["name"].split("/")[0]: entry
                for entry in json.loads(text[text.index("{"):])["benchmarks"]}

    def core(self, names):
        quick = ["--quick"] if self.quick else []
        results = self.benchmark("core_benchmark", *quick, "--benchmark_filter=^(" + "|".join(names) + ")(/|$)")
        for name, entry in results.items():
            row = self.rows[name]
            row.measured = entry.get("ratio", entry.get("worst_state"))
            if name == "plant":
                row.note = f"error {entry['our_error']:.0e}, peer {entry['peer_error']:.0e}"
            if name == "filter_speed":
                row.note = f"{1e9 * entry['ours']:.0f} ns"
            if name == "filter_accuracy" and self.quick:
                row.note = "30 000 steps"
            if name == "flat_cost" and self.quick:
                row.note = "after 600 s"
            if name == "closed_loop":
                self.rows["speed"].measured = entry["speed"]

    def octave(self):
        program = shutil.which("octave-cli")
        if not program:
            self.rows["octave"].note = "octave is not installed"
            return
        ratios = []
        for _ in range(3 if self.quick else 7):
            peer = float(self.run(program, "--norc", ROOT / "benchmark" / "paper_loop.m", 4000,
                                  stderr=subprocess.DEVNULL).split()[0])
            ours = self.benchmark("core_benchmark", "--quick", "--benchmark_filter=^filter_speed")
            ratios.append(peer / ours["filter_speed"]["ours"])
        self.rows["octave"].measured = statistics.median(ratios)

    def bag(self, seconds):
        path = self.work / f"{seconds}.bag"
        if not path.exists():
            self.say(f"simulating a bag of {seconds} s")
            self.run(self.programs / "simulate", "--config", CONFIG, "--duration", seconds,
                     "--output", path)
        return path

    def identify(self):
        results = self.benchmark("bag_benchmark", self.bag(300), CONFIG)
        row = self.rows["identify_wall"]
        row.measured = 1.0 / results["identify_wall"]["ratio"]
        row.note = f"processor {1.0 / results['identify_processor']['ratio']:.2f}x"

    def processor_time(self, *command):
        begin = os.times()
        self.run(*command)
        end = os.times()
        return end.children_user + end.children_system - begin.children_user - begin.children_system

    def bag_order(self):
        bag = self.bag(60 if self.quick else 300)
        others = {order: self.work / f"{order}_{bag.name}" for order in ("bursts", "topics")}
        for order, path in others.items():
            self.run(self.programs / "reorder_bag", bag, path, order)
        tools = {"identify": ("--config", CONFIG), "validate_bag": (), "summarise_run": (),
                 "export_csv": ("--output", self.work / "log.csv")}
        worst, note = 0.0, ""
        for tool, options in tools.items():
            ratios = {order: [] for order in others}
            for _ in range(3 if self.quick else 9):
                straight = self.processor_time(self.programs / tool, bag, *options)
                for order, path in others.items():
                    ratios[order].append(
                        self.processor_time(self.programs / tool, path, *options) / straight)
            for order, found in ratios.items():
                self.say(f"  {tool}, {order}: {statistics.median(found):.3f}")
                if statistics.median(found) > worst:
                    worst, note = statistics.median(found), f"`{tool}`, {order}"
        self.rows["bag_order"].measured = worst
        self.rows["bag_order"].note = note

    def python(self):
        bag = self.bag(30 if self.quick else 60)
        ratios = []
        for _ in range(2 if self.quick else 5):
            times = []
            for command in ([self.programs / "identify", bag, "--config", CONFIG],
                            ["/usr/bin/python3", ROOT / "benchmark" / "identify_in_python.py", bag,
                             "14e3", "22000"]):
                times.append(self.processor_time(*command))
            ratios.append(times[1] / times[0])
        self.rows["python"].measured = statistics.median(ratios)
        self.rows["python"].note = f"{'30' if self.quick else '60'} s bag"

    def memory(self, name, seconds):
        bag = self.bag(seconds)
        beyond = []
        for _ in range(1 if seconds > 1000 else 3):
            peer = int(self.run(self.programs / "peak_memory", self.programs / "read_bag", bag))
            ours = int(self.run(self.programs / "peak_memory", self.programs / "identify", bag,
                                "--config", CONFIG))
            beyond.append((ours - peer) * 1024e-6)
        self.rows[name].measured = statistics.median(beyond)
        if name == "memory_long" and seconds < 10800:
            self.rows[name].note = f"{seconds} s"

    # Measurements of the ROS graph.

    def environment(self):
        with socket.socket() as free:
            free.bind(("localhost", 0))
            port = free.getsockname()[1]
        return dict(os.environ, ROS_MASTER_URI=f"http://localhost:{port}", ROS_HOSTNAME="localhost",
                    ROS_LOG_DIR=str(self.work / "log"), ROS_PACKAGE_PATH=os.environ.get("ROS_PACKAGE_PATH", "")), port

    def graph(self, seconds, **arguments):
        """Blocks per second of wall time in a launched run."""
        environment, port = self.environment()
        command = ["roslaunch", "-p", str(port), "ring_gyro", "simulation.launch",
                   f"duration:={seconds}", *(f"{name}:={value}" for name, value in arguments.items())]
        done = subprocess.run(command, env=environment, text=True, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, timeout=300, check=False)
        found = re.search(r"end of the run: ([0-9.]+) s simulated in ([0-9.]+) s", done.stdout)
        if not found:
            sys.exit("measure: the launched run has not ended:\n" + done.stdout[-3000:])
        return 1000.0 * float(found.group(1)) / float(found.group(2))

    def echo(self, blocks, *spinner):
        environment, port = self.environment()
        master = subprocess.Popen(["rosmaster", "--core", "-p", str(port)], env=environment,
                                  stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        loops = None
        try:
            for _ in range(100):
                with socket.socket() as look:
                    if look.connect_ex(("localhost", port)) == 0:
                        break
                time.sleep(0.1)
            program = ["taskset", "-c", "0", str(self.programs / "echo_pair")]
            loops = subprocess.Popen([*program, "loops", *spinner], env=environment)
            text = subprocess.run([*program, "plant", str(blocks), "200", *spinner], env=environment,
                                  text=True, stdout=subprocess.PIPE, timeout=300, check=True).stdout
            return float(text)
        finally:
            for process in (loops, master):
                if process:
                    process.terminate()  # a background job of a shell ignores an interrupt
                    process.wait(10)

    def lockstep(self):
        seconds = 20 if self.quick else 60
        own_core = {"loop_prefix": "taskset -c 0"}
        bare, full, strong = [], [], []
        for _ in range(3 if self.quick else 7):
            echo = self.echo(1000 * seconds)
            bare.append(self.graph(seconds, identify="false", **own_core) / echo)
            full.append(self.graph(seconds, compensate="true", record=self.work / "graph.bag",
                                   **own_core) / echo)
            strong.append(self.echo(1000 * seconds, "--network-thread") / echo)
        self.rows["lockstep"].measured = statistics.median(bare)
        self.rows["lockstep_full"].measured = statistics.median(full)
        self.rows["lockstep"].note = f"a pair with our spinner: {statistics.median(strong):.2f}x"

    def nodelets(self):
        seconds = 20 if self.quick else 60
        ratios = []
        for _ in range(3 if self.quick else 7):
            processes = self.graph(seconds, compensate="true")
            ratios.append(self.graph(3 * seconds, compensate="true", nodelets="true") / processes)
        self.rows["nodelets"].measured = statistics.median(ratios)
        self.rows["nodelets"].note = "identifier and injector running"

    def all(self, only):
        core = ["filter_speed", "filter_accuracy", "plant", "closed_loop", "chain_10Hz", "chain_1kHz",
                "flat_cost", "monte_carlo"]
        steps = [(name, lambda name=name: self.core([name])) for name in core]
        steps += [("octave", self.octave), ("identify_wall", self.identify), ("bag_order", self.bag_order),
                  ("python", self.python),
                  ("memory", lambda: self.memory("memory", 300)),
                  ("memory_long", lambda: self.memory("memory_long", 1200 if self.quick else 10800)),
                  ("lockstep", self.lockstep), ("nodelets", self.nodelets)]
        for name, step in steps:
            if only and name not in only:
                continue
            self.say(f"measuring {name}")
            step()


def table(all_rows):
    header = ["what", "peer, same run", "must", "aim", "measured", "reached"]
    lines = [header, ["---"] * len(header)] + [row.cells() for row in all_rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def processor():
    for line in Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.machine()


def write(path, text):
    page = path.read_text()
    if BEGIN not in page or END not in page:
        sys.exit(f"measure: {path} lacks the lines {BEGIN} and {END}")
    head, rest = page.split(BEGIN, 1)
    path.write_text(head + BEGIN + "\n\n" + text + "\n\n" + END + rest.split(END, 1)[1])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("programs", type=Path)
    parser.add_argument("--quick", action="store_true", help="shorter runs, shorter bags")
    parser.add_argument("--only", nargs="+", help="rows by name: " + ", ".join(rows()))
    parser.add_argument("--output", type=Path, help="page with the marked place of the table")
    parser.add_argument("--work", type=Path, help="folder for bags, kept; otherwise a temporary one")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        work = arguments.work or Path(temporary)
        work.mkdir(parents=True, exist_ok=True)
        measurement = Measurement(arguments.programs.resolve(), arguments.quick, work.resolve())
        measurement.all(arguments.only)
    shown = [row for row in measurement.rows.values() if row.measured is not None or not arguments.only]
    kind = "short runs (`--quick`)" if arguments.quick else "full runs"
    text = (f"{processor()}, {os.cpu_count()} cores, load average {os.getloadavg()[0]:.1f} at the "
            f"end, {kind}, {time.strftime('%Y-%m-%d')}.\n\n" + table(shown))
    print(text)
    if arguments.output:
        write(arguments.output, text)


if __name__ == "__main__":
    main()
