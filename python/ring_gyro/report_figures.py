"""The figures of a report on one recorded run."""

import math

import numpy as np

from .style import (BLUE, DASHED, DOTTED, GREEN, GREY, PURPLE, SKY, VERMILION, WIDTH,
                    angle_axis, harmonic_bars, headroom, plt)
from .tools import Run

ANGLES = np.linspace(0.0, 360.0, 1441)
SYMBOL = {"gamma1": "$\\gamma_1$", "gamma2": "$\\gamma_2$", "mu1": "$\\mu_1$", "mu2": "$\\mu_2$",
          "ks": "$k_s$"}
BEFORE, AFTER = VERMILION, BLUE


def stretches(run: Run) -> list:
    """(flag, drift, colour, name) of the stretches in which the rate could be judged."""
    result = []
    for flag, key, colour, name in ((0.0, "drift_before", BEFORE, "not compensated"),
                                    (1.0, "drift_after", AFTER, "compensated")):
        if "missing" not in run.summary[key]:
            result.append((flag, run.summary[key], colour, name))
    return result


def why_no_drift(run: Run) -> str:
    """The reason that says most."""
    reasons = [run.summary[key].get("missing", "") for key in ("drift_before", "drift_after")]
    return next((r for r in reasons if r and r != "no such blocks"), "no locked blocks")


def harmonics_of(drift: dict) -> np.ndarray:
    return np.degrees(np.hypot(drift["cosine_rad_s"], drift["sine_rad_s"]))


def fit_of(drift: dict) -> np.ndarray:
    """Sensed rate [deg/s] at ANGLES; the pattern turns the other way."""
    theta = np.radians(ANGLES)
    rate = np.full_like(theta, drift["mean_pattern_rate_rad_s"])
    for n in range(1, 9):
        rate += drift["cosine_rad_s"][n - 1] * np.cos(n * theta)
        rate += drift["sine_rad_s"][n - 1] * np.sin(n * theta)
    return -np.degrees(rate)


def compensation_start(run: Run):
    """Time [s] from which compensation acts; None without it or when it acts from the start."""
    gains = run.series("gains")
    on = np.flatnonzero(gains["compensated"] > 0.5)
    return float(gains["time_s"][on[0]]) if len(on) and on[0] > 10 else None


def mark_compensation(run: Run, axes) -> None:
    start = compensation_start(run)
    if start is None:
        return
    for ax in np.ravel(axes):
        ax.axvline(start, color=GREY, linewidth=0.9, linestyle=DOTTED)


def time_axis(run: Run, axes) -> None:
    for ax in np.ravel(axes):
        ax.set_xlim(0.0, run.summary["duration_s"])
    np.ravel(axes)[-1].set_xlabel("time [s]")


def parameters(run: Run):
    series = run.series("estimates")
    time = series["time_s"]
    final = run.summary["final_estimate"]["parameters"]
    figure, axes = plt.subplots(3, 2, figsize=(WIDTH, 6.6), sharex=True)
    power = math.floor(math.log10(abs(final["ks"]["estimate"]) or 1.0))
    groups = ((("gamma1", "gamma2"), 1e2, "damping mismatch $\\gamma$ [%]", False),
              (("mu1", "mu2"), 1e6, "stiffness mismatch $\\mu$ [$10^{-6}$]", False),
              (("ks",), 10.0 ** -power, f"drive gain $k_s$ [$10^{power}$ s$^{{-2}}$]", True))
    for (left, right), (names, scale, label, relative) in zip(axes, groups):
        ends = []
        for name, colour in zip(names, (BLUE, VERMILION)):
            value, sigma = scale * series[name], scale * series["sigma_" + name]
            truth = final[name]["truth"]
            left.plot(time, value, color=colour, label=SYMBOL[name])
            left.fill_between(time, value - sigma, value + sigma, color=colour, alpha=0.2,
                              linewidth=0)
            ends += [scale * final[name]["estimate"]]
            if truth is not None:
                left.axhline(scale * truth, color=colour, linewidth=0.9, linestyle=DOTTED)
                ends += [scale * truth]
            unit = abs(value[-1]) if relative else scale
            right.semilogy(time, sigma / unit, color=colour, linestyle=DASHED,
                           label=f"$\\sigma$ of {SYMBOL[name]}")
            if truth is not None:
                right.semilogy(time, np.maximum(abs(value - scale * truth) / unit, 1e-14),
                               color=colour, linewidth=0.9, label=f"|error| of {SYMBOL[name]}")
        low, high = min(ends), max(ends)
        if relative:
            left.set_ylim(0.95 * low, 1.05 * high)
        else:
            margin = 0.35 * max(high - low, abs(high), abs(low), 1e-9)
            left.set_ylim(min(low, 0.0) - margin, max(high, 0.0) + margin)
        left.set_ylabel(label)
        right.set_ylabel("relative" if relative else "absolute")
        left.legend(loc="upper right", ncol=2)
        right.legend(loc="upper right", ncol=2)
    known = final["gamma1"]["truth"] is not None
    axes[0, 0].set_title("estimate, band $\\pm\\sigma$" + (", dotted: truth" if known else ""))
    axes[0, 1].set_title("$\\sigma$ as the filter has it" + (" and error" if known else ""))
    mark_compensation(run, axes)
    time_axis(run, axes[:, 0])
    time_axis(run, axes[:, 1])
    return figure


def innovations(run: Run):
    series = run.series("estimates")
    time = series["time_s"]
    consistency = run.summary["consistency"]
    figure, axes = plt.subplots(3, 1, figsize=(WIDTH, 6.0), sharex=True)
    for ax, axis in zip(axes, "ab"):
        value = 1e6 * series[f"innovation_{axis}_V"]
        bound = 1.96e6 * series[f"sigma_innovation_{axis}_V"]
        ax.fill_between(time, -bound, bound, color=SKY, alpha=0.4, linewidth=0,
                        label="95 % of them are expected here")
        ax.plot(time, value, ".", color=BLUE, markersize=2.5, markeredgewidth=0,
                label="innovation")
        late = time > 0.1 * time[-1]
        reach = 1.4 * max(np.max(abs(value[late])), np.max(bound[late]))
        ax.set_ylim(-reach, 1.35 * reach)
        ax.set_ylabel(f"innovation of ${axis}$ [µV]")
    nis = np.maximum(series["normalised_innovation_squared"], 1e-4)
    axes[2].semilogy(time, nis, ".", color=BLUE, markersize=2.5, markeredgewidth=0)
    axes[2].axhline(consistency["bound"], color=VERMILION, linewidth=1.0, linestyle=DASHED,
                    label=f"95 % are expected below {consistency['bound']:.2f}")
    axes[2].axhline(2.0, color=GREEN, linewidth=1.0, label="mean expected, 2")
    axes[2].axhline(consistency["mean"], color=PURPLE, linewidth=1.0, linestyle=DOTTED,
                    label=f"mean found, {consistency['mean']:.3g}")
    axes[2].set_ylabel("normalised innovation\nsquared")
    low = max(1e-3, 10.0 ** math.floor(math.log10(np.percentile(nis, 1))))
    high = max(100.0, 3.0 * float(np.max(nis)))
    axes[2].set_ylim(low, high * (high / low) ** 0.25)
    axes[0].legend(loc="upper right", ncol=2, markerscale=3)
    axes[2].legend(loc="upper right", ncol=3)
    mark_compensation(run, axes)
    time_axis(run, axes)
    return figure


def rate(run: Run):
    """All stretches; the last by itself when it is flatter than the first; what the fit leaves."""
    series = run.series("rates")
    chosen = stretches(run)
    zoomed = len(chosen) > 1
    figure, axes = plt.subplots(2 + zoomed, 1, figsize=(WIDTH, 4.6 + 1.5 * zoomed), sharex=True,
                                gridspec_kw={"height_ratios": [1.6] + [1.0] * (1 + zoomed)})
    for flag, drift, colour, name in chosen:
        mine = series["compensated"] == flag
        degrees = series["theta_deg"][mine] % 360.0
        rates = series["sensed_rate_deg_s"][mine]
        fit, mean = fit_of(drift), -math.degrees(drift["mean_pattern_rate_rad_s"])
        peak = math.degrees(drift["peak_to_peak_rad_s"])
        dots = {"color": colour, "markersize": 2.4, "alpha": 0.6, "markeredgewidth": 0}
        axes[0].plot(degrees, rates, ".", **dots)
        axes[0].plot(ANGLES, fit, color=colour, label=f"{name}: {peak:.3g} deg/s p-p")
        if zoomed:
            axes[1].clear()
            axes[1].plot(degrees, rates - mean, ".", **dots)
            axes[1].plot(ANGLES, fit - mean, color="black", linewidth=0.9, linestyle=DASHED)
            axes[1].set_title(f"{name}, from the mean of {mean:.4f} deg/s")
            axes[1].set_ylabel("rate [deg/s]")
        axes[-1].clear()
        axes[-1].plot(degrees, 1e3 * (rates - np.interp(degrees, ANGLES, fit)), ".", **dots)
        axes[-1].set_title(f"{name}, means over 0.1 s less the fit of harmonics 1 to 8")
    axes[-1].set_ylabel("rest [10$^{-3}$ deg/s]")
    axes[0].set_ylabel("sensed rate [deg/s]")
    headroom(axes[0], 0.25)
    axes[0].legend(loc="upper right", ncol=2)
    angle_axis(axes[-1])
    return figure


def harmonics(run: Run):
    figure, ax = plt.subplots(figsize=(WIDTH, 3.2))
    hatch = {0.0: "", 1.0: "///"}
    harmonic_bars(ax, [(name, colour, hatch[flag], harmonics_of(drift))
                       for flag, drift, colour, name in stretches(run)])
    ax.legend(loc="upper right", ncol=2)
    return figure


def gains(run: Run):
    series = run.series("gains")
    settled = series["time_s"] > (run.summary["ring_up_s"] or 0.0) + 1.0
    figure, axes = plt.subplots(2, 1, figsize=(WIDTH, 5.0), sharex=True)
    for flag, colour, name in ((0.0, BEFORE, "not compensated"), (1.0, AFTER, "compensated")):
        mine = settled & (series["compensated"] == flag)
        if not np.any(mine):
            continue
        degrees = series["theta_deg"][mine] % 360.0
        for ax, column in zip(axes, (1e6 * series["beta_s"][mine], series["alpha"][mine])):
            ax.plot(degrees, column, ".", color=colour, markersize=2.5, alpha=0.7,
                    markeredgewidth=0, label=name)
    axes[0].set_ylabel("sustain $\\beta$ [$10^{-6}$ V/(V/s)]")
    axes[1].set_ylabel("quadrature $\\alpha$ [V/V]")
    axes[1].ticklabel_format(axis="y", style="sci", scilimits=(-2, 3))
    headroom(axes[0], 0.25)
    axes[0].legend(loc="upper right", ncol=2, markerscale=4)
    angle_axis(axes[1])
    return figure


def loop_errors(run: Run):
    series = run.series("loops")
    time = series["time_s"]
    settled = time > (run.summary["ring_up_s"] or 0.0) + 1.0
    figure, axes = plt.subplots(4, 1, figsize=(WIDTH, 7.2), sharex=True)
    mean = np.nanmedian(series["a_V"][settled]) if np.any(settled) else 0.0
    axes[0].plot(time, 1e3 * (series["a_V"] - mean), color=BLUE, linewidth=0.7)
    axes[0].set_ylabel(f"$a$ less {mean:.4g} V [mV]")
    limit(axes[0], 1e3 * (series["a_V"] - mean)[settled])
    for ax, key, scale, label in ((axes[1], "b_over_a", 1e6, "$b/a$ [$10^{-6}$]"),
                                  (axes[2], "phase_error", 1e3,
                                   "$\\varphi + 90°$ [$10^{-3}$ deg]")):
        unit = "_deg" if key == "phase_error" else ""
        columns = [scale * series[f"{prefix}{key}_{end}{unit}"]
                   for prefix in ("", "true_") for end in ("low", "high")]
        ax.fill_between(time, columns[0], columns[1], color=SKY, linewidth=0.5, edgecolor=SKY,
                        alpha=0.7, label="measured, lowest to highest")
        if np.any(np.isfinite(columns[2])):
            ax.fill_between(time, columns[2], columns[3], color=BLUE, linewidth=0.5,
                            edgecolor=BLUE, label="truth")
        limit(ax, np.concatenate([column[settled] for column in columns]), 1.6)
        ax.set_ylabel(label)
        ax.legend(loc="upper right", ncol=2)
    axes[3].plot(time, -series["theta_deg"] / 360.0, color=BLUE)
    axes[3].set_ylabel("angle $-\\theta$ [turns]")
    mark_compensation(run, axes)
    time_axis(run, axes)
    return figure


def limit(ax, values, room: float = 1.3) -> None:
    values = values[np.isfinite(values)]
    if len(values) and np.max(np.abs(values)) > 0.0:
        reach = room * float(np.max(np.abs(values)))
        ax.set_ylim(-reach, reach)


def ring_up(run: Run):
    series = run.series("ring_up")
    time = series["time_s"]
    found = series["a_V"] > 0.02 * np.nanmax(series["a_V"])
    figure, axes = plt.subplots(1, 3, figsize=(WIDTH, 2.6))
    axes[0].plot(time, series["a_V"], color=BLUE)
    axes[0].set_ylabel("$a$ [V]")
    axes[1].plot(time, np.where(found, 100.0 * series["b_over_a"], np.nan), color=BLUE)
    axes[1].set_ylabel("$b/a$ [%]")
    axes[2].plot(time, np.where(found, series["phase_error_deg"], np.nan), color=BLUE)
    axes[2].set_ylabel("$\\varphi + 90°$ [deg]")
    lock = run.summary["ring_up_s"]
    for ax in axes:
        ax.set_xlabel("time [s]")
        if lock is not None:
            ax.axvline(lock, color=GREEN, linewidth=0.9, linestyle=DASHED, label="locked")
    if lock is not None:
        axes[0].legend(loc="lower right")
    return figure


def allan(run: Run):
    series = run.series("allan")
    figure, ax = plt.subplots(figsize=(0.8 * WIDTH, 3.8))
    for flag, colour, name in ((0.0, BEFORE, "not compensated"), (1.0, AFTER, "compensated")):
        mine = series["compensated"] == flag
        tau = series["tau_s"][mine]
        if not len(tau):
            continue
        ax.loglog(tau, series["total_deg_s"][mine], color=colour, linewidth=0.9, linestyle=DASHED,
                  label=f"{name}: rate as it is")
        rest, spread = series["residual_deg_s"][mine], series["relative_sigma"][mine]
        if np.any(np.isfinite(rest)):
            ax.loglog(tau, rest, color=colour, label=f"{name}: less what the angle explains")
            ax.fill_between(tau, rest * np.maximum(1.0 - spread, 0.05), rest * (1.0 + spread),
                            color=colour, alpha=0.2, linewidth=0)
            if flag == stretches(run)[-1][0]:
                ax.loglog(tau, 0.35 * rest[0] * tau[0] / tau, color=GREY, linewidth=0.8,
                          linestyle=DOTTED, label="slope of white angle noise, $-1$")
    ax.set_xlabel("averaging time $\\tau$ [s]")
    ax.set_ylabel("Allan deviation of the rate [deg/s]")
    ax.legend(loc="lower left")
    return figure


def draw(run: Run) -> tuple:
    """([(name, title, caption, function)], [what is missing and why])."""
    figures, missing = [], []
    if run.summary["final_estimate"]:
        figures.append(("parameters", "Parameters and convergence",
                        "Estimates of the identifier against time, with their standard "
                        "deviations.", parameters))
        figures.append(("innovations", "Innovations",
                        "What the filter did not foresee of a and b, its own bounds, and both "
                        "together as the normalised innovation squared.", innovations))
    else:
        missing.append("Parameters, convergence and innovations: the bag holds no "
                       "ParameterEstimate that was updated; record the identifier's topic or run "
                       "identify on the bag.")
    if stretches(run):
        figures.append(("rate_against_angle", "Rate against angle",
                        "Sensed rate, minus the rate of the pattern, over the pattern angle.",
                        rate))
        figures.append(("harmonics", "Harmonics of the rate", "Amplitudes of harmonics 1 to 8 of "
                        "the pattern angle.", harmonics))
    else:
        missing.append(f"Rate against angle and harmonics: {why_no_drift(run)}.")
    if len(run.series("gains")):
        figures.append(("gains", "Control gains against angle",
                        "Sustain gain beta, which follows the damping, and quadrature gain alpha, "
                        "which follows the stiffness; means over 0.1 s.", gains))
    else:
        missing.append("Gains against angle: the loops never locked.")
    if len(run.series("loops")):
        figures.append(("loops", "Loop errors", "Amplitude, quadrature, phase and angle over the "
                        "run.", loop_errors))
        figures.append(("ring_up", "Ring-up", "From the start of the bag until the lock.",
                        ring_up))
    else:
        missing.append("Loop errors: no block has both elements and gains.")
    if len(run.series("allan")):
        figures.append(("allan", "Allan deviation of the angle",
                        "Overlapping, of the rate that the angle integrates; solid: after the "
                        "rate that belongs to each angle (mean and harmonics) is taken away; band: "
                        "one sigma.", allan))
    else:
        missing.append("Allan deviation: too few locked blocks.")
    return figures, missing

