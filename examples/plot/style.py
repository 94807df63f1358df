"""What the plot scripts share: where the files are, and how the pictures look."""
import csv
import pathlib
import sys

import matplotlib

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


def save(figure, name):
    figure.savefig(out / name)
    print(f"{out / name}")
