#!/usr/bin/python3
"""Plots a run from what `summarise_run BAG --json DIR/summary.json --csv DIR` wrote into DIR.

usage: plot_run.py DIR [--format png|svg|pdf]

Writes DIR/parameters, DIR/rate_against_angle and DIR/loops and prints their names.
"""

import argparse
import io
import json
import sys
import textwrap
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.ticker import StrMethodFormatter  # noqa: E402

# Beside this file where the package is installed.
here = Path(__file__).resolve().parent
sys.path.insert(0, str(here if (here / "ring_gyro_figures").is_dir() else here.parent / "python"))

from ring_gyro_figures.output import write_whole  # noqa: E402
from ring_gyro_figures.tools import Series, ToolError  # noqa: E402

BLUE, ORANGE, GREEN, GREY = "#0060a8", "#d55e00", "#00795a", "#707070"
HARMONICS = 8

plt.rcParams.update({
    "font.size": 9, "axes.titlesize": 10, "axes.grid": True, "grid.alpha": 0.3,
    "grid.linewidth": 0.5, "lines.linewidth": 1.1, "legend.frameon": True,
    "legend.framealpha": 0.9, "legend.edgecolor": "none", "legend.fontsize": 8,
    "figure.constrained_layout.use": True, "axes.axisbelow": True,
})


def compensation_start(summary: dict):
    """Time [s] of the last estimate without compensation, when there was compensation after it."""
    before, final = summary["before_compensation"], summary["final_estimate"]
    if before and final and before["time_s"] < final["time_s"]:
        return before["time_s"]
    return None


def mark_compensation(axes, summary: dict, labelled) -> None:
    start = compensation_start(summary)
    if start is None:
        return
    for ax in np.ravel(axes):
        ax.axvline(start, color=GREY, linewidth=0.8, linestyle=(0, (1, 2)))
    labelled.annotate("compensation on", (start, 0.04), xycoords=("data", "axes fraction"),
                      xytext=(-4, 0), textcoords="offset points", fontsize=8, color=GREY,
                      horizontalalignment="right")


def value_limits(truths: list, values: list, relative: bool) -> tuple:
    """About the truth, or about the last estimate when nobody knows the truth."""
    known = truths or [column[-1] for column in values if len(column)] or [1.0]
    margin = (0.1 if relative else 0.4) * max(abs(value) for value in known) or 1.0
    return min(known) - margin, max(known) + margin


def plot_parameters(series: Series, summary: dict):
    time = series["time_s"]
    final = summary["final_estimate"]
    groups = [
        ("damping mismatch $\\gamma$ [%]", 100.0, [("gamma1", "$\\gamma_1$"),
                                                   ("gamma2", "$\\gamma_2$")], False, "1"),
        ("stiffness mismatch $\\mu$ [ppm]", 1e6, [("mu1", "$\\mu_1$"), ("mu2", "$\\mu_2$")],
         False, "1"),
        ("drive gain $k_s$ [1/s²]", 1.0, [("ks", "$k_s$")], True, "relative"),
    ]
    figure, axes = plt.subplots(3, 2, figsize=(9.0, 8.2), sharex=True)
    for (label, scale, members, relative, error_unit), (left, right) in zip(groups, axes):
        truths = []
        for (name, symbol), colour in zip(members, (BLUE, ORANGE)):
            value, sigma = series[name], series["sigma_" + name]
            result = final["parameters"][name] if final else {"truth": None}
            truth = result["truth"]
            left.plot(time, scale * value, color=colour, label=f"{symbol} estimate")
            left.fill_between(time, scale * (value - sigma), scale * (value + sigma),
                              color=colour, alpha=0.2, linewidth=0)
            if truth is None:
                continue
            truths.append(scale * truth)
            left.axhline(scale * truth, color=colour, linestyle="--", linewidth=0.9,
                         label=f"{symbol} truth")
            unit = abs(truth) if relative else 1.0
            right.semilogy(time, np.maximum(np.abs(value - truth) / unit, 1e-14), color=colour,
                           label=f"|error of {symbol}|")
            right.semilogy(time, sigma / unit, color=colour, linestyle=(0, (4, 2)), linewidth=0.9,
                           label=f"$\\sigma$ of {symbol}")
        left.set_ylim(*value_limits(truths, [scale * series[name] for name, _ in members], relative))
        left.set_ylabel(label)
        left.legend(ncol=len(members), loc="best")
        right.set_ylabel(f"error [{error_unit}]")
        if right.lines:
            lowest = min(np.min(line.get_ydata()) for line in right.lines[1::2])
            right.set_ylim(bottom=0.01 * lowest)  # where an error crosses zero says nothing
            right.legend(ncol=len(members), loc="best")
    axes[0, 0].set_title("estimate, band $\\pm\\sigma$")
    axes[0, 1].set_title("error against the truth and expected $\\sigma$")
    for ax in axes[-1]:
        ax.set_xlabel("time [s]")
        ax.set_xscale("log")
        ax.set_xlim(time[0] if len(time) else 0.1, time[-1] if len(time) else 1.0)
        ax.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    mark_compensation(axes, summary, axes[2, 0])
    return figure


def fitted_rate(drift: dict, degrees: np.ndarray) -> np.ndarray:
    """Sensed rate [deg/s] of the fit; the pattern turns the other way."""
    theta = np.radians(degrees)
    rate = np.full_like(theta, drift["mean_pattern_rate_rad_s"])
    for n in range(1, HARMONICS + 1):
        rate += drift["cosine_rad_s"][n - 1] * np.cos(n * theta)
        rate += drift["sine_rad_s"][n - 1] * np.sin(n * theta)
    return -np.degrees(rate)


def plot_rates(series: Series, summary: dict):
    figure = plt.figure(figsize=(9.0, 5.6))
    grid = figure.add_gridspec(2, 2, width_ratios=(1.5, 1.0), height_ratios=(1.5, 1.0))
    whole = figure.add_subplot(grid[0, 0])
    close = figure.add_subplot(grid[1, 0], sharex=whole)
    bars = figure.add_subplot(grid[:, 1])
    angle = np.linspace(0.0, 360.0, 1441)
    heights, missing = [], []
    for flag, key, colour, name in ((0, "drift_before", ORANGE, "before compensation"),
                                    (1, "drift_after", BLUE, "after compensation")):
        drift = summary[key]
        if "missing" in drift:
            missing.append(f"{name}: {drift['missing']}")
            continue
        chosen = series["compensated"] == flag
        degrees = series["theta_deg"][chosen] % 360.0
        rates = series["sensed_rate_deg_s"][chosen]
        fit = fitted_rate(drift, angle)
        peak = np.degrees(drift["peak_to_peak_rad_s"])
        whole.plot(angle, fit, color=colour, label=f"{name}: {peak:.3g} deg/s p-p")
        whole.plot(degrees, rates, ".", color=colour, markersize=2.0, alpha=0.3,
                   markeredgewidth=0)
        mean = -np.degrees(drift["mean_pattern_rate_rad_s"])
        close.clear()  # the last that there is: after compensation, or else before
        close.plot(degrees, 1e3 * (rates - mean), ".", color=colour, markersize=2.5, alpha=0.4,
                   markeredgewidth=0, label="means over 0.1 s")
        close.plot(angle, 1e3 * (fit - mean), color=colour, label="fit")
        close.set_title(f"{name}, from the mean of {mean:.5f} deg/s")
        amplitudes = np.degrees(np.hypot(drift["cosine_rad_s"], drift["sine_rad_s"]))
        heights.append((amplitudes, colour, name))
    whole.set_ylabel("sensed rate $-\\dot\\theta$ [deg/s]")
    whole.set_xlim(0, 360)
    whole.set_xticks(np.arange(0, 361, 45))
    whole.tick_params(labelbottom=False)
    whole.set_ylim(*padded(whole.get_ylim(), top=0.3))
    if heights:
        whole.legend(loc="lower right" if missing else "upper right")
    whole.set_title("rate against angle, fit of harmonics 1 to 8")
    close.set_xlabel("pattern angle $\\theta$ [deg]")
    close.set_ylabel("rate [10⁻³ deg/s]")
    if heights:
        close.set_ylim(*padded(close.get_ylim(), top=0.25))
        close.legend(loc="upper right", ncol=2, markerscale=3)
    else:
        for ax in (whole, close, bars):
            ax.set_yticks([])
    whole.text(0.5, 0.97, "\n".join(textwrap.fill(line, 60) for line in missing), fontsize=8,
               horizontalalignment="center", verticalalignment="top", transform=whole.transAxes)
    width = 0.8 / max(len(heights), 1)
    for i, (amplitudes, colour, name) in enumerate(heights):
        place = np.arange(1, HARMONICS + 1) + (i - 0.5 * (len(heights) - 1)) * width
        bars.bar(place, amplitudes, width, color=colour, label=name)
    if heights:
        bars.set_yscale("log")
    bars.set_xticks(range(1, HARMONICS + 1))
    bars.grid(axis="x", visible=False)
    bars.set_xlabel("harmonic of $\\theta$")
    bars.set_ylabel("amplitude [deg/s]")
    bars.set_title("harmonics of the rate")
    if heights:
        bars.set_ylim(*padded(bars.get_ylim(), top=0.12, log=True))
        bars.legend(loc="upper right")
    return figure


def padded(limits, top: float, log: bool = False):
    low, high = limits
    if log:
        return low, high * (high / low) ** top
    return low, high + top * (high - low)


def shade(ax, time, low, high, colour, label) -> None:
    ax.fill_between(time, low, high, color=colour, linewidth=0.6, edgecolor=colour, label=label)


def symmetric_limit(*columns) -> float:
    return 1.3 * max(float(np.nanmax(np.abs(column))) for column in columns)


def plot_loops(loops: Series, ring_up: Series, summary: dict):
    figure, axes = plt.subplots(4, 2, figsize=(9.0, 9.0), sharex="col",
                                gridspec_kw={"width_ratios": (1, 1.7)})
    rise, run = axes[:, 0], axes[:, 1]
    lock = summary["ring_up_s"]

    time = ring_up["time_s"]
    orbit = np.where(ring_up["a_V"] > 0.02 * np.nanmax(ring_up["a_V"]), 1.0, np.nan)
    nco = np.where(ring_up["frequency_Hz"] > 0.0, ring_up["frequency_Hz"], np.nan)
    nco -= np.nanmedian(nco[-50:])
    rise[0].plot(time, ring_up["a_V"], color=BLUE)
    rise[1].plot(time, 100.0 * orbit * ring_up["b_over_a"], color=BLUE)
    rise[2].plot(time, orbit * ring_up["phase_error_deg"], color=BLUE)
    rise[3].plot(time, nco, color=BLUE)
    rise[0].set_ylabel("major semi-axis $a$ [V]")
    rise[1].set_ylabel("$b/a$ [%]")
    rise[2].set_ylabel("phase error $\\varphi + 90°$ [deg]")
    rise[3].set_ylabel("NCO frequency,\nfrom its last value [Hz]")
    rise[0].set_title("ring-up from rest")
    rise[3].set_xlabel("time [s]")
    if lock is not None:
        for ax in rise:
            ax.axvline(lock, color=GREEN, linewidth=0.9, linestyle="--")
        rise[0].annotate(f"locked, {lock:.3f} s", (lock, 0.5), xycoords=("data", "axes fraction"),
                         xytext=(4, 0), textcoords="offset points", fontsize=8, color=GREEN)

    time = loops["time_s"]
    settled = time >= (lock if lock is not None else 0.0) + 1.0
    run[0].plot(time, 1e3 * (loops["a_V"] - np.nanmedian(loops["a_V"][settled])
                             if np.any(settled) else loops["a_V"]), color=BLUE, linewidth=0.7)
    run[0].set_ylabel("$a$ measured,\nfrom its median [mV]")
    for ax, key, scale, label in ((run[1], "b_over_a", 1e6, "$b/a$ [10⁻⁶]"),
                                  (run[2], "phase_error", 1e3, "phase error [10⁻³ deg]")):
        unit = "_deg" if key == "phase_error" else ""
        columns = [scale * loops[f"{prefix}{key}_{end}{unit}"]
                   for prefix in ("", "true_") for end in ("low", "high")]
        shade(ax, time, columns[0], columns[1], "#9fc3e0", "measured, with noise")
        if np.any(np.isfinite(columns[2])):
            shade(ax, time, columns[2], columns[3], BLUE, "truth")
        if np.any(settled):
            reach = symmetric_limit(*(column[settled] for column in columns
                                      if np.any(np.isfinite(column[settled]))))
            ax.set_ylim(-reach, reach)
        ax.set_ylabel(label)
        ax.legend(loc="upper right", ncol=2)
    if np.any(settled):
        reach = 1.3e3 * float(np.nanmax(np.abs(loops["a_V"][settled] -
                                               np.nanmedian(loops["a_V"][settled]))))
        run[0].set_ylim(-reach, reach)
    run[3].plot(time, loops["theta_deg"], color=BLUE)
    run[3].set_ylabel("pattern angle $\\theta$ [deg]")
    run[3].set_xlabel("time [s]")
    run[3].set_xlim(0, time[-1] if len(time) else 1)
    run[0].set_title("whole run; shaded: lowest to highest")
    mark_compensation(run, summary, run[0])
    return figure


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("directory", type=Path)
    parser.add_argument("--format", choices=("png", "svg", "pdf"), default="png")
    arguments = parser.parse_args()
    folder = arguments.directory
    try:
        summary = json.loads((folder / "summary.json").read_text())
        series = {name: Series(folder / f"{name}.csv")
                  for name in ("estimates", "rates", "loops", "ring_up")}
        figures = {
            "parameters": plot_parameters(series["estimates"], summary),
            "rate_against_angle": plot_rates(series["rates"], summary),
            "loops": plot_loops(series["loops"], series["ring_up"], summary),
        }
        for name, figure in figures.items():
            path = folder / f"{name}.{arguments.format}"
            picture = io.BytesIO()
            figure.savefig(picture, format=arguments.format, dpi=150)
            write_whole(path, picture.getvalue())
            print(path)
    except ToolError as error:
        print(f"plot_run.py: {error}", file=sys.stderr)
        return 1
    except (OSError, ValueError, KeyError) as error:
        print(f"plot_run.py: {folder}: {error}; it must hold what summarise_run --json "
              f"{folder}/summary.json --csv {folder} writes", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
