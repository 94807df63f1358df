"""What the plot scripts share: where the files are, and how the pictures look."""
import csv
import pathlib
import re
import sys

import matplotlib
import numpy

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

plt.rcParams.update({
    "figure.dpi": 120, "savefig.bbox": "tight", "font.size": 11, "axes.grid": True, "grid.alpha": 0.3,
    "axes.spines.top": False, "axes.spines.right": False, "legend.frameon": False, "lines.linewidth": 1.8,
})
BLUE, RED, GREEN, ORANGE, PURPLE, GREY = "#1f6fb4", "#c8322f", "#2a8f4d", "#e08a1e", "#7b52a3", "#666666"
out = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "out")


def read(name):
    """Rows of out/name as dictionaries, numbers as floats."""
    path = out / name
    if not path.exists():
        sys.exit(f"{path} is not there: run the example first (it writes to out/, or to --out DIR)")

    def number(text):
        try:
            return float(text)
        except ValueError:
            return text

    with open(path, newline="") as file:
        return [{key: number(value) for key, value in row.items()} for row in csv.DictReader(file)]


def frames(name):
    """Each frame of the extended XYZ file out/name as (time, columns): columns["pos"] is an array with a row a particle."""
    path = out / name
    if not path.exists():
        sys.exit(f"{path} is not there: run the example first (it writes to out/, or to --out DIR)")
    with open(path) as file:
        while line := file.readline():
            header = file.readline()
            rows = [file.readline().split() for _ in range(int(line))]
            columns, at = {}, 0
            for key, kind, width in re.findall(r"(\w+):([SRIL]):(\d+)", re.search(r"Properties=(\S+)", header)[1]):
                part = numpy.array([row[at:at + int(width)] for row in rows])
                columns[key] = part if kind in "SL" else part.astype(float)
                at += int(width)
            yield float(re.search(r"Time=(\S+)", header)[1]), columns


def save(figure, name):
    figure.savefig(out / name)
    print(f"{out / name}")
