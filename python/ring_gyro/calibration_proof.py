"""Calibration runs of several seeds, judged: the runs, the table and the pictures."""

import json
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import yaml

from .style import BLUE, GREY, VERMILION, WIDTH, angle_axis, plt
from .tools import run_jobs, run_tool

QUIET = ["--set=sense/noise_density=0", "--set=resonator/thermal_noise_density=0"]
ANGLES = np.linspace(0.0, 2.0 * np.pi, 721)
PER_HOUR = 3600.0


@dataclass
class Proof:
    """What all runs said; the lists hold one entry a seed."""
    calibrations: list
    before: list  # judgements of the first seed's device, not calibrated, noise off
    quiet: list  # judgements with the noise off: what the calibration left
    noisy: list  # judgements with all noise: what an instrument would show
    switches: list  # the first seed's, each part switched off, noise off


def degrees(value: float) -> float:
    return math.degrees(value)


def judge(config: Path, calibration, output: Path, rates: list, time: float, extra: list) -> list:
    arguments = ["--config", config]
    if calibration is not None:
        arguments += ["--config", calibration]
    rates_text = "[" + ", ".join(repr(rate) for rate in rates) + "]"
    # Status 2: some rows could not be judged, such as a gyroscope slower than its own drift.
    run_tool("judge_calibration", *arguments, "--json", output, "--time", repr(time),
             f"--set=calibration_run/verification_rates={rates_text}", *extra, allowed=(0, 2))
    return json.loads(output.read_text())


def run_all(config: Path, folder: Path, seeds: int, rates: list, time: float, workers: int,
            settings: list, progress) -> Proof:
    def calibrate(seed: int) -> dict:
        output = folder / f"calibration_{seed}.json"
        run_tool("calibrate", "--config", config, "--seed", seed, "--output",
                 folder / f"calibration_{seed}.yaml", "--json", output, *settings)
        return json.loads(output.read_text())

    def judged(seed: int, name: str, extra: list) -> list:
        return judge(config, folder / f"calibration_{seed}.yaml", folder / f"{name}_{seed}.json",
                     rates, time, ["--seed", 1000 + seed, *extra])

    names = range(1, seeds + 1)
    jobs = {f"calibration {seed}": (lambda seed=seed: calibrate(seed)) for seed in names}
    jobs["before"] = lambda: judge(config, None, folder / "before.json", rates, time, QUIET)
    first = run_jobs(jobs, workers, progress)
    jobs = {}
    for seed in names:
        jobs[f"judgement {seed}"] = lambda seed=seed: judged(seed, "quiet", QUIET)
        jobs[f"judgement with noise {seed}"] = lambda seed=seed: judged(seed, "noisy", [])
    jobs["switches"] = lambda: judged(1, "switches", [*QUIET, "--each-switch"])
    second = run_jobs(jobs, workers, progress)
    return Proof([first[f"calibration {seed}"] for seed in names], first["before"],
                 [second[f"judgement {seed}"] for seed in names],
                 [second[f"judgement with noise {seed}"] for seed in names], second["switches"])


def jobs_of(seeds: int) -> int:
    return 3 * seeds + 2


def value_of(row: dict, key: str):
    """NaN where the pattern did not turn."""
    return math.nan if "failure" in row else row[key]


def peak(row: dict) -> float:
    return max(value_of(row, "forward_peak"), value_of(row, "backward_peak"))


def cell(values: list, scale: float = 1.0, form: str = "{:.3g}") -> str:
    """Mean and largest."""
    values = [scale * value for value in values]
    if any(math.isnan(value) for value in values):
        return "stands still"
    mean = form.format(sum(values) / len(values))
    return mean if len(values) == 1 else f"{mean} ({form.format(max(values))})"


def summary_table(proof: Proof) -> str:
    lines = ["| at the rate | before, noise off | calibrated, noise off | calibrated, with noise |",
             "|---|---|---|---|"]
    for index, row in enumerate(proof.before):
        rate = f"{degrees(row['rate']):.3g} deg/s"
        quiet = [rows[index] for rows in proof.quiet]
        noisy = [rows[index] for rows in proof.noisy]
        for name, get, scale in (
                ("harmonics of the rate, p-p [deg/s]", peak, degrees(1.0)),
                ("rate-even drift, p-p [deg/h]", lambda r: value_of(r, "drift_peak_to_peak"),
                 PER_HOUR * degrees(1.0)),
                ("rate threshold [deg/h]", lambda r: value_of(r, "threshold"),
                 PER_HOUR * degrees(1.0)),
                ("angle-scale error [ppm]", lambda r: value_of(r, "slope_error"), 1e6)):
            lines.append(f"| {rate}: {name} | {cell([get(row)], scale)} | "
                         f"{cell([get(r) for r in quiet], scale)} | "
                         f"{cell([get(r) for r in noisy], scale)} |")
    return "\n".join(lines) + "\n"


def switch_table(proof: Proof) -> str:
    cases = {}
    for row in proof.switches:
        cases.setdefault(row["case"], []).append(row)
    lines = ["| | harmonics of the rate, p-p [deg/s] | rate-even drift, p-p [deg/h] | "
             "angle-scale error [ppm] |", "|---|---|---|---|"]
    for name, rows in cases.items():
        row = rows[min(1, len(rows) - 1)]
        lines.append(f"| {name} | {cell([peak(row)], degrees(1.0))} | "
                     f"{cell([value_of(row, 'drift_peak_to_peak')], PER_HOUR * degrees(1.0))} | "
                     f"{cell([value_of(row, 'slope_error')], 1e6)} |")
    return "\n".join(lines) + "\n"


def identified_table(proof: Proof, truth: dict) -> str:
    lines = ["| parameter | the device | identified, mean error (largest) | sigma |",
             "|---|---|---|---|"]
    for name, true in truth.items():
        found = [run["parameters"][name] for run in proof.calibrations]
        relative = name in ("drive_gain", "decay_rate")
        scale = 1.0 / true if relative else 1.0
        errors = [scale * (one["value"] - true) for one in found]
        sigma = scale * sum(one["sigma"] for one in found) / len(found)
        largest = max(errors, key=abs)
        lines.append(f"| {name}{', relative' if relative else ''} | {true:.6g} | "
                     f"{sum(errors) / len(errors):.2g} ({largest:.2g}) | {sigma:.1g} |")
    return "\n".join(lines) + "\n"


def harmonics(function: dict) -> np.ndarray:
    values = np.full_like(ANGLES, function["constant"])
    for n, (cosine, sine) in enumerate(zip(function["cosine"], function["sine"]), 1):
        values += cosine * np.cos(n * ANGLES) + sine * np.sin(n * ANGLES)
    return values


def slope(function: dict) -> np.ndarray:
    values = np.zeros_like(ANGLES)
    for n, (cosine, sine) in enumerate(zip(function["cosine"], function["sine"]), 1):
        values += n * (sine * np.cos(n * ANGLES) - cosine * np.sin(n * ANGLES))
    return values


def figure(proof: Proof):
    """Drift and angle scale against the angle, before and after, on scales of their own."""
    drawn, axes = plt.subplots(2, 2, figsize=(WIDTH, 4.6), sharex=True)
    before = next((row for row in reversed(proof.before) if "failure" not in row), None)
    at = np.degrees(ANGLES)
    titles = (("drift before [deg/s]", "drift after [deg/h]"),
              ("angle-scale error before [ppm]", "angle-scale error after [ppm]"))
    for row, (pick, factors) in enumerate((
            (lambda r: harmonics(r["drift"]), (degrees(1.0), PER_HOUR * degrees(1.0))),
            (lambda r: slope(r["angle_error"]), (1e6, 1e6)))):
        if before is not None:
            axes[row][0].plot(at, factors[0] * pick(before), color=VERMILION)
        for i, rows in enumerate(proof.quiet):
            axes[row][1].plot(at, factors[1] * pick(rows[-1]), color=BLUE if i == 0 else GREY,
                              linewidth=1.2 if i == 0 else 0.7,
                              label=("one seed" if i == 0 else "others" if i == 1 else None))
        for column in range(2):
            axes[row][column].set_title(titles[row][column])
            angle_axis(axes[row][column], "" if row == 0 else "pattern angle $\\theta$ [deg]")
    if len(proof.quiet) > 1:
        axes[0][1].legend(loc="upper right")
    return drawn


def truth_of(config: Path) -> dict:
    """What the configuration says of the ring; gamma and the axes are those of the ring itself."""
    ring = {key: float(value) for key, value in
            yaml.safe_load(config.read_text())["resonator"].items()}
    names = ("gamma1", "gamma2", "mu1", "mu2", "drive_gain", "natural_frequency")
    truth = {name: ring[name] for name in names if name in ring}
    truth["decay_rate"] = math.pi * ring["natural_frequency"] / ring["quality_factor"]
    return truth
