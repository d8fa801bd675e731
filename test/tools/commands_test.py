#!/usr/bin/python3
"""Smoke test of the commands in Python: report and reproduce_paper, on short runs.

usage: commands_test.py FOLDER_OF_PROGRAMS CONFIG_FOLDER [RESULT.xml]
"""

import json
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import junit  # noqa: E402

PROGRAMS, CONFIG = Path(sys.argv[1]), Path(sys.argv[2])


def run(name: str, *arguments) -> subprocess.CompletedProcess:
    return subprocess.run([str(PROGRAMS / name), *map(str, arguments)], stdin=subprocess.DEVNULL,
                          capture_output=True, text=True, timeout=900, check=False)


class Report(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.folder = Path(cls.scratch.name)

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    def simulate(self, name: str, duration: float, *overrides,
                 preset: str = "paper_experiment") -> Path:
        bag = self.folder / f"{name}.bag"
        done = run("simulate", "--config", CONFIG / f"{preset}.yaml", "--output", bag,
                   "--duration", duration, *(f"--set={o}" for o in overrides))
        self.assertEqual(done.returncode, 0, done.stderr)
        return bag

    def test_one_file_with_everything(self):
        bag = self.simulate("run", 36)
        page, figures = self.folder / "run.html", self.folder / "figures"
        done = run("report", bag, "--output", page, "--figures", figures)
        # The pick-off of this device is not in the model, which the report may not pass over.
        self.assertEqual(done.returncode, 2, done.stderr)
        misfit = done.stderr.strip().splitlines()[-1]
        self.assertIn(f"{bag}: the data do not fit the model", misfit)
        text = page.read_text()
        self.assertIn("class=doubt", text)
        self.assertNotIn("converged from", text)
        names = {"parameters", "innovations", "rate_against_angle", "harmonics", "gains", "loops", "ring_up",
                 "allan"}
        self.assertEqual(set(re.findall(r"<h2 id=(\w+)>", text)), names)
        self.assertEqual(len(re.findall(r'src="data:image/png;base64,iVBOR', text)), len(names))
        self.assertEqual({p.name for p in figures.iterdir()},
                         {f"{name}.{kind}" for name in names for kind in ("png", "pdf")})
        self.assertNotRegex(text, r'(src|href)="(?!data:)')
        self.assertNotIn("class=missing", text)

    def test_says_what_a_short_run_does_not_hold(self):
        bag = self.simulate("short", 0.15)
        page = self.folder / "short.html"
        done = run("report", bag, "--output", page)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("Rate against angle", done.stdout)
        self.assertIn("no ParameterEstimate", done.stdout)
        self.assertIn("class=missing", page.read_text())

    def test_a_fit_that_is_none_is_not_converged(self):
        fits = self.simulate("fits", 8, "control/virtual_rate=1.0", preset="paper_simulation")
        for bag, status in ((fits, 0), (self.simulate("misfit", 8), 2)):
            done = run("summarise_run", bag)
            self.assertEqual(done.returncode, status, done.stderr)
            self.assertEqual(len(done.stderr.splitlines()), status // 2, done.stderr)
            self.assertEqual("the data do not fit the model" in done.stderr, status == 2)
            self.assertEqual("filter: converged" in done.stdout, status == 0, done.stdout)
        page = self.folder / "fits.html"
        done = run("report", fits, "--output", page)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertNotIn("class=doubt", page.read_text())

    def test_refuses_in_one_line(self):
        empty = self.folder / "empty.bag"
        empty.write_bytes(b"")
        for bag in (empty, self.folder / "absent.bag"):
            page = self.folder / "none.html"
            done = run("report", bag, "--output", page)
            self.assertEqual(done.returncode, 1)
            self.assertEqual(len(done.stderr.strip().splitlines()), 1, done.stderr)
            self.assertIn(bag.name, done.stderr)
            self.assertFalse(page.exists())


class Readme(unittest.TestCase):
    def test_its_own_run_shows_the_drift_before_and_after(self):
        text = (CONFIG.parent / "README.md").read_text().replace("\\\n", "")
        command, = re.findall("rosrun ring_gyro simulate (.*?) +#", text)
        with tempfile.TemporaryDirectory() as scratch:
            bag, summary = Path(scratch) / "run.bag", Path(scratch) / "summary.json"
            words = [str(CONFIG.parent / word) if word.startswith("config/") else
                     word.replace("/tmp/run.bag", str(bag)) for word in command.split()]
            self.assertEqual(run("simulate", *words).returncode, 0)
            self.assertEqual(run("summarise_run", bag, "--json", summary).returncode, 0)
            drift = json.loads(summary.read_text())
        for stretch in ("drift_before", "drift_after"):
            self.assertNotIn("missing", drift[stretch])
        # The launch above it is of the same run.
        launch, = re.findall("roslaunch ring_gyro simulation.launch (.*record:=.*?) +#", text)
        after, = re.findall(r"compensation/start_after=(\d+)", command)
        self.assertIn(f"compensate:=true compensate_after:={after}", re.sub(" +", " ", launch))


class Refusal(unittest.TestCase):
    def test_names_every_number_out_of_range(self):
        device = ("--config", CONFIG / "untuned.yaml")
        for name, wrong in (
                ("tune_modes", {"gain": "-1", "time": "-3", "target": "nan", "passes": "0"}),
                ("frequency_response", {"span": "nan", "points": "4", "settling": "0"})):
            done = run(name, *device, *(f"--{key}={value}" for key, value in wrong.items()))
            self.assertEqual(done.returncode, 1, name)
            lines = done.stderr.strip().splitlines()
            self.assertEqual(len(lines), len(wrong), done.stderr)
            for (key, value), line in zip(wrong.items(), lines):
                self.assertRegex(line, f"^--{key} = {value}: out of range; allowed: .")

    def refused(self, name: str, *arguments) -> str:
        done = run(name, *arguments)
        self.assertEqual(done.returncode, 1, name)
        self.assertEqual(len(done.stderr.strip().splitlines()), 1, done.stderr)
        return done.stderr

    def test_output_that_cannot_be_written(self):
        device = ("--config", CONFIG / "paper_simulation.yaml")
        with tempfile.TemporaryDirectory() as scratch:
            bag, log = Path(scratch) / "run.bag", Path(scratch) / "log.csv"
            for command in (("simulate", *device, "--duration", 0.2, "--output", bag),
                            ("export_csv", bag, "--output", log)):
                self.assertEqual(run(*command).returncode, 0, command)
            for command in (("simulate", *device, "--duration", 0.1, "--output"),
                            ("calibrate", *device, "--output"),
                            ("judge_calibration", *device, "--json"),
                            ("tune_modes", "--config", CONFIG / "untuned.yaml", "--output"),
                            ("frequency_response", *device, "--output"),
                            ("monte_carlo", *device, "--count", 1, "--output"),
                            ("identify", bag, *device, "--json"),
                            ("import_csv", log, "--output"),
                            ("export_csv", bag, "--output")):
                line = self.refused(*command, "/absent/file")
                self.assertIn("/absent/file: cannot be written: No such file or directory; the "
                              "folder /absent does not exist; make it or choose", line)

    def test_device_that_is_not_told_or_told_twice(self):
        for name in ("identify", "compare_identifiers"):
            self.assertIn("--config FILE or --preset NAME", self.refused(name, "run.bag"))
            self.assertIn("exclude each other", self.refused(
                name, "run.bag", "--config", "x.yaml", "--preset", "realistic"))
            self.assertIn("presets are the files of", self.refused(
                name, "run.bag", "--preset", "absent"))


class Paper(unittest.TestCase):
    def test_quick(self):
        with tempfile.TemporaryDirectory() as scratch:
            folder = Path(scratch) / "paper"
            done = run("reproduce_paper", "--output", folder, "--quick")
            self.assertEqual(done.returncode, 0, done.stderr)
            names = {f"figure{n:02d}" for n in range(4, 12)} | {"convergence", "threshold",
                                                               "bandwidth"}
            self.assertEqual({p.stem for p in folder.glob("*.png")}, names)
            rows = json.loads((folder / "paper.json").read_text())["rows"]
            found = {row["what"]: row["values"] for row in rows}
            for case, low, high in ((1, 8.0, 9.5), (3, 1.4, 2.0), (4, 0.0, 1.0)):
                value = found[f"case {case}, rate, peak to peak"]["deg_s"]
                self.assertTrue(low <= value <= high, f"case {case}: {value} deg/s")
            fourth = found["4th harmonic, cases 1 to 4"]["deg_s"]
            self.assertLess(max(fourth) / min(fourth), 1.02)
            self.assertIn("| 8 | case 4", (folder / "paper.md").read_text())

    def test_refuses_in_one_line(self):
        with tempfile.NamedTemporaryFile() as file:
            done = run("reproduce_paper", "--output", Path(file.name) / "inside", "--quick")
        self.assertEqual(done.returncode, 1)
        self.assertEqual(len(done.stderr.strip().splitlines()), 1, done.stderr)


class Package(unittest.TestCase):
    """What others import."""

    def test_messages_and_helpers_are_one_package(self):
        code = ("import ring_gyro.msg, ring_gyro.tools, ring_gyro.style, ring_gyro.output\n"
                "print(ring_gyro.msg.OrbitalElements().status.amplitude_locked)")
        done = subprocess.run([sys.executable, "-c", code], check=False, text=True, cwd="/",
                              capture_output=True)
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "False\n", ""))


if __name__ == "__main__":
    sys.exit(junit.main(sys.argv[3:]))
