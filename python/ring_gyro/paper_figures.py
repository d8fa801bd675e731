"""The figures of the paper, drawn from the runs, and what was measured besides."""

import math

import numpy as np
from matplotlib.ticker import FixedLocator, NullFormatter, ScalarFormatter

from .paper_runs import (ANGLES, CASES, PARAMETERS, Results, amplitudes, convergence_time,
                         final_estimate, peak_to_peak, residual, threshold_of)
from .style import (AMBER, BLACK, BLUE, DASHED, DOTTED, GREEN, GREY, PURPLE, VERMILION, WIDTH,
                    angle_axis, harmonic_bars, headroom, plt)

STYLE = {"case1": (VERMILION, "", "case 1: not compensated"),
         "case2": (PURPLE, "///", "case 2: over-compensated"),
         "case3": (GREEN, "...", "case 3: $\\gamma_2$ left"),
         "case4": (BLUE, "", "case 4: compensated")}
SYMBOL = {"gamma1": "$\\gamma_1$", "gamma2": "$\\gamma_2$", "mu1": "$\\mu_1$", "mu2": "$\\mu_2$",
          "ks": "$k_s$"}


def truth_of(run) -> dict:
    parameters = run.summary["final_estimate"]["parameters"]
    return {name: parameters[name]["truth"] for name in PARAMETERS}


def plain_log_ticks(axis, ticks) -> None:
    axis.set_major_locator(FixedLocator(ticks))
    axis.set_major_formatter(ScalarFormatter())
    axis.set_minor_formatter(NullFormatter())


def log_time(ax, last: float) -> None:
    ax.set_xscale("log")
    ax.set_xlim(0.3, last)
    plain_log_ticks(ax.xaxis, [t for t in (0.3, 1, 3, 10, 30, 100, 300) if t <= last * 1.01])
    ax.set_xlabel("time [s]")


def trace(ax, run, name, scale, colour, line, label) -> None:
    series = run.series("estimates")
    ax.plot(series["time_s"], scale * series[name], color=colour, linestyle=line, label=label,
            linewidth=1.4 if line == "-" else 1.0)


def truth_line(ax, value, colour, label=None) -> None:
    ax.axhline(value, color=colour, linewidth=0.8, linestyle=DOTTED, label=label)


def say_last(ax, run, names, scale, unit) -> None:
    """The last values, when they are beyond the axes."""
    final = final_estimate(run)
    text = ", ".join(f"{SYMBOL[name]} = {scale * final[name]:.3g}{unit}" for name in names)
    ax.text(0.98, 0.95, f"at the end {text}", transform=ax.transAxes, ha="right", va="top",
            fontsize=8, bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.9, "pad": 2})


TUNINGS = (("derived", "derived tuning"), ("paper_tuning", "the $Q$ and $R$ printed in the paper"))


def figure4(results: Results):
    truth = truth_of(results.derived)
    figure, axes = plt.subplots(2, 2, figsize=(WIDTH, 4.6), sharex=True, sharey="col")
    for (left, right), (run, title) in zip(axes, TUNINGS):
        run = getattr(results, run)
        for name, colour in (("gamma1", BLUE), ("gamma2", VERMILION)):
            trace(left, run, name, 1.0, colour, "-", SYMBOL[name])
            truth_line(left, truth[name], colour)
        trace(right, run, "ks", 1e-5, BLUE, "-", "$k_s$")
        truth_line(right, 1e-5 * truth["ks"], BLUE)
        left.set_ylabel("damping mismatch $\\gamma$")
        right.set_ylabel("drive gain $k_s$ [$10^5$ s$^{-2}$]")
        left.set_title(title)
        right.set_title(title)
    truth_line(axes[0, 0], math.nan, GREY, "simulated device")
    say_last(axes[1, 0], results.paper_tuning, ("gamma1", "gamma2"), 1.0, "")
    axes[0, 0].set_ylim(-0.06, 0.12)
    axes[0, 1].set_ylim(0.8 * 1.1, 1.15 * 1.1)
    axes[0, 0].legend(loc="upper right", ncol=3)
    for ax in axes[1]:
        log_time(ax, results.derived.series("estimates")["time_s"][-1])
    return figure


def figure5(results: Results):
    truth = truth_of(results.derived)
    figure, axes = plt.subplots(2, 2, figsize=(WIDTH, 4.6), sharex=True, sharey="col")
    for (left, right), (run, title) in zip(axes, TUNINGS):
        series = getattr(results, run).series("estimates")
        for name, colour in (("mu1", BLUE), ("mu2", VERMILION)):
            left.plot(series["time_s"], 1e6 * series[name], color=colour, label=SYMBOL[name])
            truth_line(left, 1e6 * truth[name], colour)
            right.loglog(series["time_s"], np.maximum(abs(series[name] - truth[name]), 1e-13),
                         color=colour, label=f"|error of {SYMBOL[name]}|", linewidth=1.0)
            right.loglog(series["time_s"], series["sigma_" + name], color=colour,
                         linestyle=DASHED, linewidth=0.9, label=f"$\\sigma$ of {SYMBOL[name]}")
        left.set_ylabel("stiffness mismatch $\\mu$ [$10^{-6}$]")
        right.set_ylabel("error of $\\mu$")
        left.set_title(title)
        right.set_title(title)
    truth_line(axes[0, 0], math.nan, GREY, "simulated device")
    say_last(axes[1, 0], results.paper_tuning, ("mu1", "mu2"), 1e6, " $10^{-6}$")
    axes[0, 0].set_ylim(-62, 22)
    axes[0, 0].legend(loc="upper right", ncol=3)
    axes[0, 1].set_ylim(1e-12, 1e2)
    axes[0, 1].legend(loc="upper right", ncol=2)
    for ax in axes[1]:
        log_time(ax, series["time_s"][-1])
    return figure


def figure6(results: Results):
    tuning = results.tuning
    figure, axes = plt.subplots(1, 2, figsize=(WIDTH, 3.1), sharey=True)
    centre = 14195.0
    for ax, sweep, when in zip(axes, (tuning.before, tuning.after), ("before", "after")):
        for values, colour, line, axis in ((sweep.x, BLUE, "-", "x"),
                                           (sweep.y, VERMILION, DASHED, "y")):
            ax.plot(sweep.frequency - centre, 20.0 * np.log10(np.abs(values)), color=colour,
                    linestyle=line, label=f"axis ${axis}$ over drive ${axis}$")
        split = (f"{sweep.split:.2f} Hz" if sweep.split > 0.1 else
                 f"under {1e3 * 10 ** math.ceil(math.log10(max(sweep.split, 1e-6))):.3g} mHz")
        ax.set_title(f"{when} mode tuning: split {split}")
        ax.set_xlabel(f"frequency less {centre:g} Hz [Hz]")
        ax.set_xlim(-3, 2)
    axes[0].set_ylabel("gain [dB, V/V]")
    axes[1].legend(loc="upper right")
    return figure


def figure7(results: Results):
    truth = truth_of(results.identification)
    figure, axes = plt.subplots(2, 3, figsize=(WIDTH, 4.8), sharex=True, sharey="col")
    end = results.identification.summary["duration_s"]
    groups = ((("gamma1", "gamma2"), 1.0, "damping mismatch $\\gamma$", (-0.04, 0.08)),
              (("mu1", "mu2"), 1e6, "stiffness mismatch $\\mu$ [$10^{-6}$]", (-1.6, 2.2)),
              (("ks",), 1e-6, "drive gain $k_s$ [$10^6$ s$^{-2}$]", (2.1, 2.28)))
    runs = ((results.identification, "derived tuning"),
            (results.experiment_paper_tuning, "printed $Q$ and $R$"))
    for row, (run, title) in zip(axes, runs):
        for ax, (names, scale, label, limits) in zip(row, groups):
            for name, colour in zip(names, (BLUE, VERMILION)):
                trace(ax, run, name, scale, colour, "-", SYMBOL[name])
                truth_line(ax, scale * truth[name], colour)
            ax.set_ylabel(label)
            ax.set_ylim(*limits)
            ax.set_xlim(0, end)
            ax.set_xticks(np.arange(0, end + 1, 60))
            ax.set_title(title)
    truth_line(axes[0, 2], math.nan, GREY, "simulated device")
    for ax, place, columns in zip(axes[0], ("upper right", "upper right", "lower right"),
                                  (2, 2, 1)):
        ax.legend(loc=place, ncol=columns)
    for ax in axes[1]:
        ax.set_xlabel("time [s]")
    return figure


def measured_rates(run):
    series = run.series("rates")
    flag = 0.0 if "missing" in run.summary["drift_after"] else 1.0
    chosen = series["compensated"] == flag
    return series["theta_deg"][chosen] % 360.0, series["sensed_rate_deg_s"][chosen]


def figure8(results: Results):
    figure, ax = plt.subplots(figsize=(WIDTH, 3.9))
    for name in CASES:
        run = results.cases[name]
        colour, _, label = STYLE[name]
        degrees, rates = measured_rates(run)
        ax.plot(degrees, rates, ".", color=colour, markersize=3.2, markeredgewidth=0, alpha=0.8)
        ax.plot([], [], "o", color=colour, markersize=4,
                label=f"{label}, {peak_to_peak(run):.2f} deg/s p-p")
        ax.plot(ANGLES, model_rate(results, run), color=BLACK, linewidth=0.9,
                linestyle=DASHED)
    ax.plot([], [], color=BLACK, linewidth=0.9, linestyle=DASHED,
            label="averaged model with the estimates")
    angle_axis(ax)
    ax.set_ylabel("sensed rate [deg/s]")
    ax.set_ylim(6.5, 20.5)
    ax.legend(loc="upper center", ncol=2)
    return figure


def model_rate(results: Results, run) -> np.ndarray:
    """Steering as the identified drive gain makes it, and the drift of what is left of gamma."""
    device = results.experiment
    steering = math.degrees(run.drift["virtual_rate_rad_s"])
    gain = final_estimate(run)["ks"] / device.drive_gain
    return steering * gain + device.drift(residual(run), ANGLES)


def figure9(results: Results):
    figure, ax = plt.subplots(figsize=(WIDTH, 3.6))
    for name in CASES:
        run = results.cases[name]
        colour, _, label = STYLE[name]
        gains = run.series("gains")
        settled = gains["time_s"] > 5.0
        ax.plot(gains["theta_deg"][settled] % 360.0, 1e6 * gains["beta_s"][settled], ".",
                color=colour, markersize=3.2, markeredgewidth=0, alpha=0.8)
        ax.plot([], [], "o", color=colour, markersize=4, label=label)
        ax.plot(ANGLES, 1e6 * results.experiment.beta(residual(run), final_estimate(run)["ks"],
                                                      ANGLES),
                color=BLACK, linewidth=0.9, linestyle=DASHED)
    ax.plot([], [], color=BLACK, linewidth=0.9, linestyle=DASHED,
            label="averaged model with the estimates")
    angle_axis(ax)
    ax.set_ylabel("sustain gain $\\beta$ [10$^{-6}$ V/(V/s)]")
    headroom(ax, 0.35)
    ax.legend(loc="upper center", ncol=2)
    return figure


def figure10(results: Results):
    figure, axes = plt.subplots(1, 2, figsize=(WIDTH, 3.2), sharey=True)
    for name in CASES:
        run = results.cases[name]
        colour, _, label = STYLE[name]
        series = run.series("estimates")
        for ax, column, expected in zip(axes, ("residual_gamma1", "residual_gamma2"),
                                        CASES[name] or results.experiment.gamma):
            ax.plot(series["time_s"], series[column], color=colour, label=label,
                    linestyle=DASHED if name == "case4" else "-")
            ax.axhline(expected, color=colour, linewidth=0.9, linestyle=DOTTED)
    for ax, symbol in zip(axes, ("$\\gamma_1$", "$\\gamma_2$")):
        ax.set_xlabel("time [s]")
        ax.set_title(f"residual {symbol}")
        ax.set_xlim(0, 60)
        ax.set_ylim(-0.03, 0.06)
    axes[0].set_ylabel("estimate of what compensation leaves")
    axes[1].plot([], [], color=GREY, linewidth=0.9, linestyle=DOTTED, label="as the paper has it")
    axes[1].legend(loc="upper right", ncol=1)
    return figure


def figure11(results: Results):
    figure, ax = plt.subplots(figsize=(WIDTH, 3.4))
    harmonic_bars(ax, [(STYLE[name][2], STYLE[name][0], STYLE[name][1],
                        amplitudes(results.cases[name])) for name in CASES])
    ax.legend(loc="upper right", ncol=2)
    return figure


def figure_convergence(results: Results):
    figure, ax = plt.subplots(figsize=(0.72 * WIDTH, 3.4))
    rates = np.array(sorted(results.steering))
    runs = [results.steering[rate] for rate in rates]
    lock = np.array([run.summary["ring_up_s"] for run in runs])
    said = np.array([run.summary["converged_s"] or math.nan for run in runs]) - lock
    ax.loglog(rates, said, "s-", color=VERMILION, markersize=4, label="the filter says so")
    ax.loglog(rates, [convergence_time(run) for run in runs], "o-", color=BLUE, markersize=4,
              label="estimates stay near their last values")
    limit = results.experiment.threshold(results.experiment.gamma)
    fine = np.geomspace(1.01 * limit, 60.0, 400)
    ax.loglog(fine, 180.0 / np.sqrt(fine ** 2 - limit ** 2), color=GREY, linestyle=DASHED,
              label="half a turn of the pattern")
    ax.loglog([12.0], [120.0], "*", color=BLACK, markersize=10, label="the paper, two minutes")
    ax.axvline(limit, color=GREY, linewidth=0.9, linestyle=DOTTED)
    ax.annotate("threshold", (limit, 0.03), xycoords=("data", "axes fraction"), xytext=(3, 0),
                textcoords="offset points", fontsize=8, color=GREY)
    ax.set_xlim(3.7, 60)
    ax.set_ylim(2, 400)
    plain_log_ticks(ax.xaxis, [5, 10, 20, 50])
    plain_log_ticks(ax.yaxis, [3, 10, 30, 100, 300])
    ax.set_xlabel("steering rate [deg/s]")
    ax.set_ylabel("time to converge after the lock [s]")
    ax.legend(loc="upper right")
    return figure


def figure_threshold(results: Results):
    figure, (left, right) = plt.subplots(1, 2, figsize=(WIDTH, 3.3),
                                        gridspec_kw={"width_ratios": (1.25, 1)})
    limit = results.experiment.threshold(results.experiment.gamma)
    fine = np.concatenate([np.linspace(0, limit, 50), np.linspace(limit, 8.5, 800)])
    left.plot(fine, np.sqrt(np.maximum(fine ** 2 - limit ** 2, 0.0)), color=BLACK, linewidth=0.9,
              linestyle=DASHED, label="$\\sqrt{\\Omega^2-(\\xi_0\\omega_0|\\gamma|)^2}$")
    for name, colour, marker, label in (("linear", BLUE, "o", "linear pick-off"),
                                        ("pick-off", VERMILION, "x", "cubic pick-off")):
        points = results.thresholds[name]
        left.plot([p.rate for p in points], [p.mean for p in points], marker,
                  color=colour, markersize=5, label=label, fillstyle="none")
    left.axvline(limit, color=GREY, linewidth=0.9, linestyle=DOTTED)
    left.set_title(f"not compensated: $\\xi_0\\omega_0|\\gamma|$ = {limit:.2f} deg/s")
    left.set_xlim(0, 8.5)
    left.set_ylim(-0.3, 8.5)
    points = results.thresholds["compensated"]
    right.plot([p.rate for p in points], [p.mean for p in points], "s", color=GREEN,
               markersize=5, label="compensated, cubic pick-off", fillstyle="none")
    top = 1.05 * max([1.0] + [p.rate for p in points if p.rate <= 2.0])
    right.set_xlim(0, top)
    right.set_ylim(-0.04 * top, top)
    found = threshold_of(points)["deg_s"]
    fine = np.concatenate([[0.0], np.linspace(found, top, 300)])
    right.plot(fine, np.sqrt(np.maximum(fine ** 2 - found ** 2, 0.0)), color=BLACK, linewidth=0.9,
               linestyle=DASHED, label=f"the same with {found:.2f} deg/s")
    right.axvline(found, color=GREY, linewidth=0.9, linestyle=DOTTED)
    right.set_title("compensated: the 4th harmonic is left")
    for ax in (left, right):
        low, high = ax.get_xlim()
        ax.plot([low, high], [low, high], color=GREY, linewidth=0.7, label="ideal")
        ax.set_xlabel("rotation rate of the case [deg/s]")
        ax.legend(loc="upper left")
    left.set_ylabel("mean sensed rate [deg/s]")
    return figure


def figure_bandwidth(results: Results):
    figure, (gain, delay) = plt.subplots(2, 1, figsize=(WIDTH, 4.4), sharex=True,
                                         gridspec_kw={"height_ratios": (1.5, 1)})
    for name, colour, marker, label in (("uncompensated", VERMILION, "x", "not compensated"),
                                        ("compensated", BLUE, "o", "compensated")):
        points = results.gains[name]
        frequency = [p.frequency for p in points]
        gain.semilogx(frequency, [20.0 * math.log10(p.gain) for p in points], marker + "-",
                      color=colour, markersize=5, fillstyle="none", label=label)
        fast = [p for p in points if p.frequency >= 10.0]
        delay.semilogx([p.frequency for p in fast], [1e3 * p.delay for p in fast], marker + "-",
                       color=colour, markersize=5, fillstyle="none")
    gain.axhline(-3.0, color=GREY, linewidth=0.9, linestyle=DOTTED)
    for ax in (gain, delay):
        ax.axvspan(1.0 / 360.0, 100.0, color=AMBER, alpha=0.15, linewidth=0,
                   label="the paper expects: 1/360 to 100 Hz")
    delay.axhline(1e3 * results.group_delay, color=BLACK, linewidth=0.9, linestyle=DASHED,
                  label="the group delay that the messages carry")
    gain.set_ylabel("gain of the angle [dB]")
    gain.set_ylim(-6, 2)
    gain.legend(loc="lower left")
    delay.set_ylabel("delay [ms]")
    delay.set_ylim(0.0, 1.0)
    handles, labels = delay.get_legend_handles_labels()
    delay.legend(handles[1:], labels[1:], loc="lower left")
    delay.set_xlabel("frequency of the rotation of the case [Hz]")
    delay.set_xlim(2e-3, 500)
    return figure


def draw(results: Results):
    """(file name, caption, function) of each figure."""
    figures = [
        ("figure04", "damping mismatch and drive gain, section 6", figure4),
        ("figure05", "stiffness mismatch, section 6", figure5),
        ("figure07", "identification at 12 deg/s, section 7", figure7),
        ("figure08", "rate against angle, four cases of compensation", figure8),
        ("figure09", "sustain gain against angle", figure9),
        ("figure10", "damping mismatch that compensation leaves, as identified", figure10),
        ("figure11", "harmonics of the measured rate", figure11),
        ("convergence", "time to converge against steering rate", figure_convergence),
        ("threshold", "mean sensed rate against the rate of the case", figure_threshold),
        ("bandwidth", "gain and delay of the measured angle", figure_bandwidth),
    ]
    if results.tuning is not None:
        figures.insert(2, ("figure06", "frequency response before and after mode tuning",
                           figure6))
    return figures

