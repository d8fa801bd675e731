#!/usr/bin/python3
"""What every program that writes promises of its outputs, with private links, pipes and devices.

usage: outputs_test.py FOLDER_OF_PROGRAMS CONFIG_FOLDER [RESULT.xml]
"""

import json
import os
import resource
import signal
import stat
import subprocess
import sys
import tempfile
import threading
import time
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import junit  # noqa: E402

PROGRAMS, CONFIG = Path(sys.argv[1]), Path(sys.argv[2]) / "paper_simulation.yaml"


def run(name: str, *arguments, file_size=None) -> subprocess.CompletedProcess:
    """`file_size`: bytes that no file of it may exceed, as on a disk that is full."""
    def limit():
        if file_size is not None:
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (file_size, file_size))
    return subprocess.run([str(PROGRAMS / name), *map(str, arguments)], stdin=subprocess.DEVNULL,
                          capture_output=True, text=True, timeout=300, check=False,
                          preexec_fn=limit)


class Outputs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory(prefix="ring gyro outputs ")
        cls.inputs = Path(cls.scratch.name) / "inputs"
        cls.inputs.mkdir()
        cls.bag, cls.log = cls.inputs / "run.bag", cls.inputs / "log.csv"
        for command in (("simulate", "--config", CONFIG, "--duration", 1, "--output", cls.bag),
                        ("export_csv", cls.bag, "--output", cls.log)):
            done = run(*command)
            assert done.returncode == 0, done.stderr
        # Each program up to its output.
        device = ("--config", CONFIG)
        sweep = ("--points", 9, "--settling", 0.05)
        cls.writers = {
            "simulate": ("simulate", *device, "--duration", 0.2, "--output"),
            "identify --json": ("identify", cls.bag, *device, "--json"),
            "identify --estimates": ("identify", cls.bag, *device, "--estimates"),
            "summarise_run": ("summarise_run", cls.bag, "--json"),
            "export_csv": ("export_csv", cls.bag, "--output"),
            "import_csv": ("import_csv", cls.log, "--output"),
            "frequency_response": ("frequency_response", *device, *sweep, "--csv"),
            "monte_carlo": ("monte_carlo", *device, "--set", "run/duration=2", "--count", 1,
                            "--output"),
            "identify_batch": ("identify_batch", cls.bag, *device, "--output"),
        }
        cls.all_writers = dict(cls.writers, report=("report", cls.bag, "--output"))

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(dir=self.scratch.name))

    def refused(self, *command) -> str:
        done = run(*command)
        self.assertEqual(done.returncode, 1, f"{command}: {done.stdout}")
        self.assertEqual(len(done.stderr.strip().splitlines()), 1, done.stderr)
        return done.stderr

    def test_a_link_stays_and_its_target_is_written(self):
        for name, command in self.all_writers.items():
            folder = self.folder / name
            (folder / "elsewhere").mkdir(parents=True)
            target, link = folder / "elsewhere" / "target", folder / "link"
            link.symlink_to("elsewhere/middle")
            (folder / "elsewhere" / "middle").symlink_to("target")
            done = run(*command, link)
            self.assertIn(done.returncode, (0, 2), f"{name}: {done.stderr}")
            self.assertTrue(link.is_symlink(), name)
            self.assertTrue(target.is_file() and not target.is_symlink(), name)
            self.assertGreater(target.stat().st_size, 0, name)
            self.assertEqual(target.stat().st_mode & 0o777, 0o666 & ~umask(), name)
            self.assertEqual(sorted(os.listdir(folder)), ["elsewhere", "link"], name)
            self.assertEqual(sorted(os.listdir(folder / "elsewhere")), ["middle", "target"], name)

    def test_a_pipe_gets_what_a_file_would(self):
        for name, command in self.all_writers.items():
            whole, pipe = self.folder / "whole", self.folder / "pipe"
            self.assertIn(run(*command, whole).returncode, (0, 2), name)
            os.mkfifo(pipe)
            got = []
            reader = threading.Thread(target=lambda: got.append(pipe.read_bytes()))
            reader.start()
            done = run(*command, pipe)
            self.assertIn(done.returncode, (0, 2), f"{name}: {done.stderr}")
            self.assertTrue(stat.S_ISFIFO(pipe.stat().st_mode), name)
            reader.join(60)
            self.assertEqual(len(got[0]), whole.stat().st_size, name)
            if name != "simulate":
                self.assertEqual(got[0], whole.read_bytes(), name)
            for path in (pipe, whole):
                path.unlink()
            self.assertEqual(os.listdir(self.folder), [], name)

    def test_the_standard_output_is_written_into(self):
        link = self.folder / "stdout"  # never the system's own
        link.symlink_to("/proc/self/fd/1")
        done = run("identify", self.bag, "--config", CONFIG, "--json", link)
        self.assertIn(done.returncode, (0, 2), done.stderr)
        text = done.stdout
        self.assertIn("gamma1", text[:text.index("\n{")])
        json.loads(text[text.index("\n{"):])
        done = run("report", self.bag, "--output", link)
        self.assertIn("</html>", done.stdout)
        self.assertTrue(link.is_symlink())

    def test_a_device_stays_one(self):
        null = self.folder / "null"
        try:
            os.mknod(null, 0o666 | stat.S_IFCHR, os.makedev(1, 3))
            null.write_bytes(b"x")
        except PermissionError:
            self.skipTest("devices are for root, and not on every file system")
        for name, command in self.writers.items():
            done = run(*command, null)
            self.assertIn(done.returncode, (0, 2), f"{name}: {done.stderr}")
            self.assertTrue(stat.S_ISCHR(null.stat().st_mode), name)
        self.assertEqual(os.listdir(self.folder), ["null"])

    def test_an_output_that_is_an_input_is_refused(self):
        config, other = self.folder / "config.yaml", self.folder / "other.bag"
        config.write_bytes(CONFIG.read_bytes())
        bag, log = self.folder / "run.bag", self.folder / "log.csv"
        for copy, original in ((bag, self.bag), (log, self.log), (other, self.bag)):
            copy.write_bytes(original.read_bytes())
        lines = self.folder / "lines.jsonl"
        lines.write_text("")
        device = ("--config", config)
        cases = (
            (bag, ("identify", other, bag, *device, "--json")),
            (config, ("identify", bag, *device, "--json")),
            (bag, ("identify", bag, *device, "--estimates")),
            (config, ("simulate", *device, "--duration", 0.1, "--output")),
            (log, ("import_csv", log, "--output")),
            (bag, ("export_csv", bag, "--output")),
            (bag, ("summarise_run", bag, "--json")),
            (config, ("calibrate", *device, "--output")),
            (config, ("judge_calibration", *device, "--json")),
            (config, ("frequency_response", *device, "--csv")),
            (config, ("monte_carlo", *device, "--count", 1, "--output")),
            (lines, ("monte_carlo", "--merge", lines, "--output")),
            (lines, ("identify_batch", "--merge", lines, "--output")),
            (bag, ("identify_batch", bag, *device, "--output")),
            (bag, ("report", bag, "--output")),
        )
        for file, command in cases:
            before = file.read_bytes()
            link, hard = self.folder / "link", self.folder / "hard"
            link.symlink_to(file.name)
            os.link(file, hard)
            for output in (file, link, hard, self.folder / "." / ".." / self.folder.name / file.name):
                self.assertIn("is an input too", self.refused(*command, output), command)
                self.assertEqual(file.read_bytes(), before, command)
            self.assertTrue(link.is_symlink())
            for path in (link, hard):
                path.unlink()
        profile = self.folder / "rates.txt"
        profile.write_text("0 0\n1 0.1\n")
        self.assertIn("is an input too", self.refused(
            "simulate", *device, "--set", "rotation/profile=file", "--set",
            f"rotation/file={profile}", "--duration", 0.1, "--output", profile))

    def test_two_outputs_that_are_one_are_refused(self):
        one, device = self.folder / "one", ("--config", CONFIG)
        for command in (("identify", self.bag, *device, "--json", one, "--estimates", one),
                        ("calibrate", *device, "--output", one, "--json", one),
                        ("frequency_response", *device, "--output", one, "--csv", one),
                        ("summarise_run", self.bag, "--csv", self.folder, "--json",
                         self.folder / "loops.csv"),
                        ("report", self.bag, "--figures", self.folder, "--output",
                         self.folder / "loops.png")):
            self.assertIn("is another output too", self.refused(*command), command)
        self.assertEqual(os.listdir(self.folder), [])

    def test_a_second_writer_waits_for_nobody_and_breaks_nothing(self):
        bag, link = self.folder / "run.bag", self.folder / "link"
        link.symlink_to("run.bag")
        first = subprocess.Popen([str(PROGRAMS / "simulate"), "--config", str(CONFIG), "--duration",
                                  "100000", "--output", str(bag)], stdout=subprocess.DEVNULL)
        try:
            give_up = time.monotonic() + 60
            while not list(self.folder.glob("run.bag.*.active")):
                self.assertLess(time.monotonic(), give_up)
                time.sleep(0.01)
            for output in (bag, link):
                self.assertIn("is being written by another program", self.refused(
                    "simulate", "--config", CONFIG, "--duration", 0.1, "--output", output))
            left, = self.folder.glob("run.bag.*.active")
        finally:
            first.kill()
            first.wait()
        # Killed, it is in nobody's way, and what it left stays.
        done = run("simulate", "--config", CONFIG, "--duration", 0.1, "--output", bag)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue(left.exists() and bag.exists())

    def test_a_file_that_stands_in_the_way_is_not_touched(self):
        precious = self.folder / "precious"
        precious.write_text("precious")
        for name in ("out.part", "out.active"):
            (self.folder / name).symlink_to("precious")
        for command in self.writers.values():
            self.assertIn(run(*command, self.folder / "out").returncode, (0, 2))
            (self.folder / "out").unlink()
        self.assertEqual(precious.read_text(), "precious")

    def test_a_full_disk_is_said_in_one_line(self):
        lines, bag = self.folder / "lines.jsonl", self.folder / "run.bag"
        for command, size in ((("simulate", "--config", CONFIG, "--duration", 30, "--output", bag),
                               3_000_000),
                              (("import_csv", self.log, "--output", bag), 5_000),
                              (("export_csv", self.bag, "--output", bag), 5_000),
                              (("identify", self.bag, "--config", CONFIG, "--json", bag), 100),
                              (("identify", self.bag, "--config", CONFIG, "--estimates", bag), 500),
                              (("report", self.bag, "--output", bag), 300_000),
                              (("monte_carlo", "--config", CONFIG, "--count", 1, "--set",
                                "run/duration=2", "--output", lines), 100),
                              (("identify_batch", self.bag, "--config", CONFIG, "--output", lines),
                               10)):
            lines.unlink(missing_ok=True)
            done = run(*command, file_size=size)
            self.assertEqual(done.returncode, 1, f"{command}: {done.stderr}")
            said = [line for line in done.stderr.splitlines() if "cannot be written" in line]
            self.assertEqual(len(said), 1, done.stderr)
            self.assertIn(f"{command[-1]}: cannot be written: File too large; raise", said[0])
            self.assertFalse(bag.exists())
            # Of what grew with the run the part before is kept, and named.
            for left in self.folder.glob("run.bag.*"):
                self.assertEqual(command[0], "simulate")
                self.assertIn(f"; what came before is in {left}", said[0])
                self.assertEqual(run("summarise_run", left).returncode, 1)  # no index
                self.assertIn(run("identify", left, "--config", CONFIG).returncode, (0, 2))
                left.unlink()

    def test_a_run_that_was_cut_is_called_one(self):
        bag, summary = self.folder / "run.bag", self.folder / "summary.json"
        done = run("validate_bag", self.bag)
        self.assertEqual((done.returncode, done.stdout.count("fine")), (0, 1), done.stdout)
        process = subprocess.Popen([str(PROGRAMS / "simulate"), "--config", str(CONFIG),
                                    "--duration", "1000", "--output", str(bag)],
                                   stdout=subprocess.PIPE, text=True)
        give_up = time.monotonic() + 60
        while sum(p.stat().st_size for p in self.folder.glob("run.bag.*.active")) < 1_000_000:
            self.assertLess(time.monotonic(), give_up)
            time.sleep(0.01)
        process.terminate()
        self.assertIn("(interrupted)", process.communicate(timeout=60)[0])
        done = run("validate_bag", bag)
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertIn("warning: the run was cut after block ", done.stdout)
        self.assertNotIn("fine", done.stdout)
        done = run("summarise_run", bag, "--json", summary)
        self.assertIn("the run was cut", done.stdout)
        self.assertTrue(json.loads(summary.read_text())["cut"])
        run("report", bag, "--output", self.folder / "report.html")
        self.assertIn("<td>cut: ", (self.folder / "report.html").read_text())


def umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


if __name__ == "__main__":
    sys.exit(junit.main(sys.argv[3:]))
