#!/usr/bin/python3
"""rosrun ring_gyro plot_run.py: the figures of a report, from what
`summarise_run BAG --json DIR/summary.json --csv DIR` wrote into DIR."""

import argparse
import sys
from pathlib import Path

from ring_gyro import report_figures
from ring_gyro.output import write_whole
from ring_gyro.style import picture, plt
from ring_gyro.tools import Run, ToolError


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="plot_run.py", description="Draws a summarised run, each figure a file in its folder.")
    parser.add_argument("directory", type=Path, metavar="DIR",
                        help="what `summarise_run BAG --json DIR/summary.json --csv DIR` wrote")
    parser.add_argument("--format", choices=("png", "svg", "pdf"), default="png")
    return parser.parse_args()


def main() -> int:
    chosen = arguments()
    folder = chosen.directory
    try:
        run = Run(folder)
        figures, missing = report_figures.draw(run)
        for name, _, _, function in figures:
            figure = function(run)
            path = folder / f"{name}.{chosen.format}"
            write_whole(path, picture(figure, chosen.format))
            plt.close(figure)
            print(path)
    except ToolError as error:
        print(f"plot_run.py: {error}", file=sys.stderr)
        return 1
    except (OSError, ValueError, KeyError) as error:
        print(f"plot_run.py: {folder}: {error}; it must hold what summarise_run --json "
              f"{folder}/summary.json --csv {folder} writes", file=sys.stderr)
        return 1
    for line in missing:
        print(f"not drawn: {line}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
