"""The report on a recorded run: one HTML file."""

import base64
import html
import math
import tempfile
from pathlib import Path

from . import report_figures
from .output import OutputFile, require_apart, write_whole
from .style import picture, plt
from .tools import Progress, ToolError, summarise

STYLE = """
body { font: 15px/1.45 sans-serif; color: #222; max-width: 62em; margin: 2em auto; padding: 0 1em }
h1 { font-size: 1.5em } h2 { font-size: 1.15em; margin-top: 2em }
table { border-collapse: collapse; margin: 0.8em 0 }
th, td { border-bottom: 1px solid #ccc; padding: 0.25em 0.9em 0.25em 0; text-align: left }
td.n { text-align: right; font-variant-numeric: tabular-nums }
img { max-width: 100% } .missing, .doubt { background: #fff3d6; padding: 0.5em 0.8em }
figcaption { color: #555 } figure { margin: 0.5em 0 }
"""


def table(head: list, rows: list) -> str:
    """Cells of rows: text, or (text,) for a number."""
    text = "<table>"
    if head:
        text += "<tr>" + "".join(f"<th>{html.escape(cell)}</th>" for cell in head) + "</tr>"
    for row in rows:
        text += "<tr>"
        for cell in row:
            number = isinstance(cell, tuple)
            text += f"<td{' class=n' if number else ''}>" + \
                html.escape(cell[0] if number else cell) + "</td>"
        text += "</tr>"
    return text + "</table>\n"


def overview(summary: dict) -> str:
    settings = summary["settings"]
    rows = [("length", f"{summary['duration_s']:.3f} s, {summary['blocks']} blocks of "
                       f"{1e3 * settings['block_duration_s']:g} ms"),
            ("blocks missing", str(summary["missing_blocks"])),
            ("end", "cut: its end_of_run is not in the bag, or its last blocks are not"
             if summary["cut"] else "as the plant announced it"),
            ("locked", "never" if summary["ring_up_s"] is None else
             f"after {summary['ring_up_s']:.3f} s; {summary['unlocked_blocks']} blocks unlocked "
             "after that")]
    errors = summary["loop_errors"]
    if errors:
        rows.append(("largest loop errors of the true motion",
                     f"phase {math.degrees(errors['phase_rad']):.4f} deg, "
                     f"|b|/a {errors['b_over_a']:.1e}, a {errors['a_relative']:.1e} relative"))
    consistency = summary["consistency"]
    if consistency:
        mean, tolerance = consistency["mean"], consistency["mean_tolerance"]
        verdict = "as expected" if abs(mean - 2.0) < 2.0 * tolerance else (
            "above: something acts that the model does not hold, or the noise is understated; "
            "sigma is too small" if mean > 2.0 else "below: the noise is overstated")
        rows.append(("normalised innovation squared",
                     f"{mean:.3g} in the mean, 2 ± {tolerance:.2g} expected ({verdict}); "
                     f"{100 * consistency['share_inside']:.1f} % inside the 95 % bound"))
    return table([], rows)


def parameter_table(summary: dict) -> str:
    final = summary["final_estimate"]
    known = any(p["truth"] is not None for p in final["parameters"].values())
    units = {"ks": "1/s²"}
    head = ["parameter", "estimate", "sigma", "unit"] + (["truth", "error"] if known else [])
    rows = []
    for name, p in final["parameters"].items():
        row = [name, (f"{p['estimate']:.7g}",), (f"{p['sigma']:.1e}",), units.get(name, "1")]
        if known:
            row += [(f"{p['truth']:.7g}",), (f"{p['error']:.1e}",)] if p["truth"] is not None \
                else ["", ""]
        rows.append(row)
    text = table(head, rows)
    said = summary["converged_s"]
    doubt = summary.get("misfit")
    text += "<p>At {:.1f} s, from {:.1f} s of data; {}. ".format(
        final["time_s"], final["used_time_s"],
        "does not fit the data" if doubt else
        "not converged" if said is None else f"converged from {said:.1f} s on")
    text += (f"Blocks used {final['used_blocks']}, rejected {final['rejected_blocks']}, lost "
             f"{final['lost_blocks']}; {math.degrees(final['angle_covered_rad']):.0f} deg of "
             "pattern angle seen. Damping mismatch that the acting compensation leaves: "
             f"({final['residual_gamma1']:.6f}, {final['residual_gamma2']:.6f}).</p>\n")
    return text


def drift_table(run) -> str:
    chosen = report_figures.stretches(run)
    head = ["sensed rate against angle"] + [name for _, _, _, name in chosen]
    lines = [
        ("from, to [s]", lambda d: f"{d['begin_s']:.1f}, {d['end_s']:.1f}"),
        ("whole turns", lambda d: str(d["whole_turns"])),
        ("mean over angle [deg/s]", lambda d: f"{-math.degrees(d['mean_pattern_rate_rad_s']):.6f}"),
        ("peak to peak, harmonics 1 to 8 [deg/s]",
         lambda d: f"{math.degrees(d['peak_to_peak_rad_s']):.5f}"),
        ("rest about the fit, rms [deg/s]",
         lambda d: f"{math.degrees(d['residual_rms_rad_s']):.5f}")]
    for n in range(1, 9):
        lines.append((f"harmonic {n}, amplitude [deg/s]",
                      lambda d, n=n: f"{report_figures.harmonics_of(d)[n - 1]:.5f}"))
    return table(head, [[label] + [(value(d),) for _, d, _, _ in chosen]
                        for label, value in lines])


def settings_table(run) -> str:
    settings = run.summary["settings"]
    rows = [("session", str(settings["session"])),
            ("block", f"{1e3 * settings['block_duration_s']:g} ms"),
            ("group delay of the demodulator", f"{1e3 * settings['group_delay_s']:.4g} ms"),
            ("case", "rotated" if settings["case_rotated"] else "not rotated, or not known")]
    for _, drift, _, name in report_figures.stretches(run):
        rows.append((f"virtual rate, {name}",
                     f"{math.degrees(drift['virtual_rate_rad_s']):.4f} deg/s"))
    if len(run.series("loops")):
        rows.append(("NCO frequency at the end", f"{run.series('loops')['frequency_Hz'][-1]:.5f} Hz"))
    if settings["true_natural_frequency_hz"]:
        rows.append(("simulated device", f"f0 {settings['true_natural_frequency_hz']:.3f} Hz, "
                                         f"Q {settings['true_quality_factor']:.0f}"))
    return table([], rows)


def page(bag: Path, run, drawn: list, missing: list) -> str:
    summary = run.summary
    parts = [f"<!DOCTYPE html>\n<html lang=en><meta charset=utf-8><title>{html.escape(bag.name)}"
             f"</title><style>{STYLE}</style>\n<h1>Run {html.escape(bag.name)}</h1>\n",
             overview(summary)]
    if summary.get("misfit"):
        parts.append(f"<p class=doubt>{html.escape(summary['misfit'])}</p>\n")
    parts += [f"<p class=missing>{html.escape(line)}</p>\n" for line in missing]
    if summary["final_estimate"]:
        parts += ["<h2>Parameters</h2>\n", parameter_table(summary)]
    if report_figures.stretches(run):
        parts += ["<h2>Drift</h2>\n", drift_table(run)]
    for name, title, caption, data in drawn:
        coded = base64.b64encode(data).decode()
        parts.append(f"<h2 id={name}>{html.escape(title)}</h2>\n<figure><img alt=\""
                     f"{html.escape(title)}\" src=\"data:image/png;base64,{coded}\">"
                     f"<figcaption>{html.escape(caption)}</figcaption></figure>\n")
    parts += ["<h2>Settings</h2>\n", settings_table(run), "</html>\n"]
    return "".join(parts)


def make(bag: Path, output: Path, figures_folder) -> tuple:
    """(number of figures, what is missing and why, why the identification does not fit its data)"""
    if not bag.is_file():
        raise ToolError(f"{bag}: no such file; name a recorded run")
    require_apart([output], [bag])
    if figures_folder:
        figures_folder.mkdir(parents=True, exist_ok=True)
    progress = Progress(9)
    with OutputFile(output) as file, \
            tempfile.TemporaryDirectory(prefix="ring_gyro_report_") as scratch:
        run = summarise(bag, Path(scratch))
        figures, missing = report_figures.draw(run)
        if figures_folder:
            require_apart([output, *(figures_folder / f"{name}.{kind}" for name, *_ in figures
                                     for kind in ("png", "pdf"))], [bag])
        progress.total = 1 + len(figures)
        progress.step("bag read")
        drawn = []
        for name, title, caption, function in figures:
            figure = function(run)
            data = picture(figure)
            if figures_folder:
                write_whole(figures_folder / f"{name}.png", data)
                write_whole(figures_folder / f"{name}.pdf", picture(figure, "pdf"))
            plt.close(figure)
            drawn.append((name, title, caption, data))
            progress.step(name)
        progress.clear()
        file.finish(page(bag, run, drawn, missing))
        return len(drawn), missing, run.summary.get("misfit")
