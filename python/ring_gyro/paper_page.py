"""The paper's figures as files, and the page that shows them."""

import json
import math
from pathlib import Path

from . import paper_figures, paper_table
from .output import write_whole
from .style import picture, plt
from .tools import Progress


def finite(value):
    """JSON knows no NaN: what is unknown is null."""
    if isinstance(value, dict):
        return {key: finite(item) for key, item in value.items()}
    if isinstance(value, list):
        return [finite(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def write_figures(results, folder: Path) -> list:
    written = []
    figures = paper_figures.draw(results)
    progress = Progress(2 * len(figures))
    for name, caption, function in figures:
        figure = function(results)
        for kind in ("png", "pdf"):
            write_whole(folder / f"{name}.{kind}", picture(figure, kind))
            progress.step(f"{name}.{kind}")
        plt.close(figure)
        written.append((name, caption))
    progress.clear()
    return written


def markdown(rows: list, figures: list, quick: bool) -> str:
    text = "# The paper's figures, reproduced\n\n"
    if quick:
        text += "Short runs (`--quick`): the numbers are rough.\n\n"
    text += paper_table.as_markdown(rows)
    for name, caption in figures:
        text += f"\n![{caption}]({name}.png)\n\n*{name}: {caption}.*\n"
    return text


def write(results, folder: Path, quick: bool) -> tuple:
    """Figures, paper.md and paper.json; gives the rows of the table and how many figures."""
    figures = write_figures(results, folder)
    rows = paper_table.table(results)
    write_whole(folder / "paper.json",
                json.dumps(finite({"quick": quick, "rows": rows}), indent=1) + "\n")
    write_whole(folder / "paper.md", markdown(rows, figures, quick))
    return rows, len(figures)
