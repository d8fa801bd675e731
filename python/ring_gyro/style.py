"""One look for all figures: colours that the colour-blind can tell apart, sizes for print."""

import io

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

BLUE, VERMILION, GREEN, PURPLE = "#0072b2", "#d55e00", "#009e73", "#aa4499"
SKY, AMBER, GREY, BLACK = "#56b4e9", "#e69f00", "#707070", "#000000"
DOTTED, DASHED = (0, (1, 2)), (0, (4, 2))
DPI = 150
WIDTH = 7.2  # inches

plt.rcParams.update({
    "font.size": 9, "axes.titlesize": 9.5, "axes.labelsize": 9, "axes.grid": True,
    "grid.alpha": 0.3, "grid.linewidth": 0.5, "lines.linewidth": 1.2, "legend.frameon": True,
    "legend.framealpha": 0.9, "legend.edgecolor": "none", "legend.fontsize": 8,
    "legend.borderpad": 0.3, "figure.constrained_layout.use": True, "axes.axisbelow": True,
    "pdf.fonttype": 42,
})


def angle_axis(ax, label: str = "pattern angle $\\theta$ [deg]") -> None:
    ax.set_xlim(0, 360)
    ax.set_xticks(np.arange(0, 361, 45))
    if label:
        ax.set_xlabel(label)


def harmonic_bars(ax, groups: list) -> None:
    """groups: (label, colour, hatch, amplitudes 1 to n [deg/s])."""
    width = 0.82 / max(len(groups), 1)
    lowest, highest = 1.0, 1e-3
    for i, (label, colour, hatch, amplitudes) in enumerate(groups):
        place = np.arange(1, len(amplitudes) + 1) + (i - 0.5 * (len(groups) - 1)) * width
        ax.bar(place, amplitudes, width, color=colour, hatch=hatch, edgecolor="white",
               linewidth=0.3, label=label)
        lowest = min(lowest, float(np.min(amplitudes)))
        highest = max(highest, float(np.max(amplitudes)))
    ax.set_yscale("log")
    low = 10.0 ** np.floor(np.log10(max(lowest, 1e-6)))
    ax.set_ylim(low, highest * (highest / low) ** 0.3)
    ax.set_xticks(range(1, 9))
    ax.grid(axis="x", visible=False)
    ax.set_xlabel("harmonic of the pattern angle")
    ax.set_ylabel("amplitude of the rate [deg/s]")


def headroom(ax, top: float = 0.2, bottom: float = 0.05) -> None:
    """Room for a legend above the curves."""
    low, high = ax.dataLim.y0, ax.dataLim.y1
    if np.isfinite(low) and np.isfinite(high) and high > low:
        ax.set_ylim(low - bottom * (high - low), high + top * (high - low))


def picture(figure, kind: str = "png") -> bytes:
    """The figure as the bytes of a file."""
    buffer = io.BytesIO()
    # No date inside, so that the same data give the same file.
    keep = {"png": {"Software": None}, "pdf": {"CreationDate": None}}.get(kind)
    figure.savefig(buffer, format=kind, dpi=DPI, metadata=keep, bbox_inches="tight",
                   pad_inches=0.05)
    return buffer.getvalue()
