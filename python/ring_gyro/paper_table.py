"""The paper's numbers beside those that were measured here."""

import math

from .paper_runs import (CASES, PARAMETERS, Results, amplitudes, convergence_time, final_estimate,
                         peak_to_peak, residual, threshold_of)


def row(figure: str, what: str, paper: str, here: str, note: str = "", **values) -> dict:
    return {"figure": figure, "what": what, "paper": paper, "here": here, "note": note,
            "values": values}


def identified(results: Results) -> list:
    rows = []
    run, truth = results.derived, results.derived.summary["final_estimate"]["parameters"]
    scale = {"gamma1": ("gamma1", 1.0, "", "0.020"), "gamma2": ("gamma2", 1.0, "", "0.030"),
             "mu1": ("mu1", 1e6, " 1e-6", "-30"), "mu2": ("mu2", 1e6, " 1e-6", "-40"),
             "ks": ("ks", 1e-5, " 1e5 /s2", "1.1")}
    for name in PARAMETERS:
        label, factor, unit, paper = scale[name]
        p = truth[name]
        error = (p["estimate"] - p["truth"]) / (p["truth"] if name == "ks" else 1.0)
        bad = results.paper_tuning.summary["final_estimate"]["parameters"][name]
        rows.append(row("4" if name in ("gamma1", "gamma2", "ks") else "5", label, paper + unit,
                        f"{factor * p['estimate']:.6f}{unit}",
                        f"error {error:.1e}{' relative' if name == 'ks' else ''}; with the "
                        f"printed Q and R {factor * bad['estimate']:.4g}{unit}",
                        estimate=p["estimate"], truth=p["truth"], sigma=p["sigma"],
                        with_paper_tuning=bad["estimate"]))
    rows.append(row("4", "time to converge, derived tuning", "", f"{convergence_time(run):.1f} s",
                    f"with the printed Q and R {verdict(results.paper_tuning)}",
                    derived_s=convergence_time(run),
                    paper_tuning_gamma_s=gamma_band_time(results.paper_tuning)))
    return rows


def verdict(run) -> str:
    """Of a filter that may well have failed."""
    time = gamma_band_time(run)
    return (f"gamma stays within 1e-3 of the truth after {time:.0f} s" if math.isfinite(time) else
            f"gamma does not settle in {run.summary['duration_s']:.0f} s")


def gamma_band_time(run, band: float = 1e-3) -> float:
    """Until gamma1 and gamma2 stay within the band of the truth [s]."""
    from .paper_runs import settled_since
    series = run.series("estimates")
    truth = run.summary["final_estimate"]["parameters"]
    names = ("gamma1", "gamma2")
    return settled_since(series["time_s"], [series[name] for name in names], (band, band),
                         [truth[name]["truth"] for name in names])


def tuned(results: Results) -> list:
    tuning = results.tuning
    if tuning is None:
        return [row("6", "frequency response", "1.5 Hz to under 10 mHz", "-",
                    results.tuning_missing)]
    return [
        row("6", "frequency split before tuning", "1.5 Hz", f"{tuning.before.split:.3f} Hz", "",
            hz=tuning.before.split),
        row("6", "frequency split after tuning", "< 10 mHz", f"{1e3 * tuning.true_split:.2g} mHz",
            f"true split; the swept sine sees {1e3 * tuning.after.split:.2g} mHz",
            true_hz=tuning.true_split, swept_hz=tuning.after.split),
        row("6", "quality factor", "22000", f"{tuning.after.quality:.0f}", "",
            quality_factor=tuning.after.quality),
        row("6", "ks by (34), from the peak", "2.0e6 /s2", f"{tuning.after.ks_peak:.3e} /s2",
            f"the whole matrix gives {tuning.after.ks_fit:.3e}: (34) takes the mean Q for that of "
            "the mode", from_peak=tuning.after.ks_peak, from_matrix=tuning.after.ks_fit),
    ]


def experiment(results: Results) -> list:
    run = results.identification
    estimate = final_estimate(run)
    truth = run.summary["final_estimate"]["parameters"]
    turns = math.radians(abs(run.series("loops")["theta_deg"][-1])) / (2.0 * math.pi)
    rows = [row("7", name, paper, f"{estimate[name]:{form}}",
                f"simulated device {truth[name]['truth']:{form}}", estimate=estimate[name],
                truth=truth[name]["truth"], sigma=truth[name]["sigma"])
            for name, paper, form in (("gamma1", "0.035", ".4f"), ("gamma2", "-0.006", ".4f"),
                                      ("mu1", "not resolved", ".2e"),
                                      ("mu2", "not resolved", ".2e"),
                                      ("ks", "2.19e6", ".4g"))]
    nis = run.summary["consistency"]["mean"]
    rows += [
        row("7", "turns of the pattern", "6", f"{turns:.2f}",
            f"in {run.summary['duration_s']:.0f} s: 6 turns at 12 deg/s are 3 minutes, not 5",
            turns=turns),
        row("7", "time to converge at 12 deg/s", "120 s", f"{convergence_time(run):.1f} s",
            f"with the printed Q and R {verdict(results.experiment_paper_tuning)}", seconds=convergence_time(run)),
        row("7", "normalised innovation squared", "", f"{nis:.3g}",
            "2 is expected: the filter sees that the cubic pick-off is not in its model", mean=nis),
    ]
    return rows


def compensation(results: Results) -> list:
    paper = {"case1": ("9", "(0.035, -0.006)"), "case2": ("8", "(-0.016, not given)"),
             "case3": ("1.5", "(0, 0.006)"), "case4": ("< 1", "(0, 0)")}
    rows = []
    for name in CASES:
        run = results.cases[name]
        gamma = residual(run)
        rows.append(row("8", f"case {name[-1]}, rate, peak to peak", paper[name][0] + " deg/s",
                        f"{peak_to_peak(run):.2f} deg/s",
                        "" if name != "case2" else "residual gamma1 alone does not make 8",
                        deg_s=peak_to_peak(run)))
        rows.append(row("10", f"case {name[-1]}, residual gamma as identified", paper[name][1],
                        f"({gamma[0]:.4f}, {gamma[1]:.4f})", "", gamma1=gamma[0],
                        gamma2=gamma[1]))
    alone = 2.0 * results.experiment.threshold((0.016, 0.0))
    rows.append(row("8", "case 2, averaged model of gamma1 = -0.016 alone", "8 deg/s",
                    f"{alone:.2f} deg/s", "2 xi0 w0 |gamma|, peak to peak", deg_s=alone))
    for gamma2, run in results.eight.values():
        rows.append(row("8", f"case 2 with gamma2 = {gamma2:+.4f} left", "8 deg/s",
                        f"{peak_to_peak(run):.2f} deg/s", "the gamma2 that makes 8 in the model",
                        gamma2=gamma2, deg_s=peak_to_peak(run)))
    for name in CASES:
        gains = results.cases[name].series("gains")
        settled = gains["time_s"] > 5.0
        beta = gains["beta_s"][settled]
        swing = (max(beta) - min(beta)) / (max(beta) + min(beta))
        rows.append(row("9", f"case {name[-1]}, swing of beta about its mean",
                        "largest" if name == "case1" else "", f"+-{100.0 * swing:.2f} %", "",
                        relative=swing))
    second = [amplitudes(results.cases[name])[1] for name in CASES]
    fourth = [amplitudes(results.cases[name])[3] for name in CASES]
    rows.append(row("11", "2nd harmonic, cases 1 to 4", "falls to negligible",
                    ", ".join(f"{value:.3f}" for value in second) + " deg/s", "",
                    deg_s=[float(value) for value in second]))
    rows.append(row("11", "4th harmonic, cases 1 to 4", "equal in all",
                    ", ".join(f"{value:.3f}" for value in fourth) + " deg/s",
                    f"equal within {100.0 * (max(fourth) / min(fourth) - 1.0):.2f} %",
                    deg_s=[float(value) for value in fourth]))
    return rows


def beyond(results: Results) -> list:
    rows = []
    for rate in sorted(results.steering):
        run = results.steering[rate]
        said = run.summary["converged_s"]
        rows.append(row("-", f"time to converge at {rate:g} deg/s",
                        "120 s" if rate == 12.0 else "", f"{convergence_time(run):.1f} s",
                        f"the filter says so after {said:.1f} s" if said else
                        "the filter has not said so", deg_s=rate, seconds=convergence_time(run)))
    model = results.experiment.threshold(results.experiment.gamma)
    for name, label in (("linear", "not compensated, linear pick-off"),
                        ("pick-off", "not compensated, cubic pick-off"),
                        ("compensated", "compensated, cubic pick-off")):
        found = threshold_of(results.thresholds[name])
        expected = f"xi0 w0 |gamma| = {model:.3f} deg/s" if name != "compensated" else "1 deg/s"
        rows.append(row("-", f"rate threshold, {label}", expected, f"{found['deg_s']:.3f} deg/s",
                        f"stands at {found['standing_deg_s']:g}, turns at "
                        f"{found['turning_deg_s']:g} deg/s", **found))
    low = threshold_of(results.thresholds["compensated"])["deg_s"] / 360.0
    rows.append(row("-", "lower end of the band: that threshold in turns per second",
                    "1/360 Hz", f"1/{1.0 / low:.0f} Hz" if low > 0.0 else "-", "", hz=low))
    points = results.gains["compensated"]
    for frequency, gain in ((p.frequency, p.gain) for p in points):
        if math.isclose(frequency, 1 / 360) or math.isclose(frequency, 100.0):
            name = "1/360 Hz" if frequency < 1.0 else "100 Hz"
            rows.append(row("-", f"gain of the angle at {name}", "within the band",
                            f"{20.0 * math.log10(gain):+.2f} dB", "", gain=gain))
    upper = crossing(points)
    rows.append(row("-", "upper end of the band: -3 dB of the angle", "100 Hz",
                    f"{upper:.0f} Hz" if math.isfinite(upper) else
                    f"above {points[-1].frequency:.0f} Hz",
                    f"delay {1e3 * points[-1].delay:.2f} ms, {1e3 * results.group_delay:.2f} ms "
                    "of it known to all that read the angle", hz=upper))
    return rows


def crossing(points: list) -> float:
    """Where the gain falls through -3 dB [Hz]."""
    level = 10.0 ** (-3.0 / 20.0)
    fast = [p for p in points if p.frequency >= 1.0]
    for before, after in zip(fast, fast[1:]):
        if before.gain >= level > after.gain:
            share = (before.gain - level) / (before.gain - after.gain)
            return before.frequency + share * (after.frequency - before.frequency)
    return math.nan


def table(results: Results) -> list:
    return (identified(results) + tuned(results) + experiment(results) + compensation(results) +
            beyond(results))


def as_text(rows: list) -> str:
    widths = [max(len(r[key]) for r in rows) for key in ("what", "paper", "here")]
    lines = [f"fig  {'quantity':<{widths[0]}}  {'paper':<{widths[1]}}  {'here':<{widths[2]}}  note"]
    for r in rows:
        lines.append(f"{r['figure']:>3}  {r['what']:<{widths[0]}}  {r['paper']:<{widths[1]}}  "
                     f"{r['here']:<{widths[2]}}  {r['note']}".rstrip())
    return "\n".join(lines) + "\n"


def as_markdown(rows: list) -> str:
    lines = ["| figure | quantity | the paper | here | note |", "|---|---|---|---|---|"]
    for r in rows:
        cells = (r["figure"], r["what"], r["paper"], r["here"], r["note"])
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return "\n".join(lines) + "\n"
