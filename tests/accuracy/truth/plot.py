#!/usr/bin/env python3
"""How wrong a success is, solver by solver, from what the long test accuracy/reference/truth wrote.

    python3 tests/accuracy/truth/plot.py build/stress/figures/reference/truth.txt.csv docs/images/stiff_truth.png
"""
import csv
import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "examples" / "plot"))
import style  # noqa: E402
from style import plt  # noqa: E402


def main():
    shares, failed, colours = {}, {}, {}
    with open(sys.argv[1], encoding="utf-8") as file:
        for row in csv.DictReader(file):
            name, share = row["solver"], float(row["share"])
            colours[name] = style.GREEN if row["library"] == "phistep" else "#888888"
            failed.setdefault(name, 0)
            shares.setdefault(name, [])
            if share < 0:
                failed[name] += 1
            else:
                shares[name].append(min(max(share, 1e-6), 1e6) if math.isfinite(share) else 1e6)
    edges = [10 ** (k / 4) for k in range(-24, 25)]
    names = list(shares)
    figure, axes = plt.subplots(figsize=(9, 0.34 * len(names) + 1))
    for place, name in enumerate(reversed(names)):
        runs = len(shares[name]) + failed[name]
        counts = [sum(low <= x < high or (high == edges[-1] and x == high) for x in shares[name])
                  for low, high in zip(edges, edges[1:])]
        for low, high, count in zip(edges, edges[1:], counts):
            if count:  # the square root lets one run of a thousand be seen
                axes.barh(place, high - low, left=low, height=0.9 * math.sqrt(count / max(counts)),
                          color=style.RED if low >= 99.9 else colours[name])
        wrong = sum(x > 100 for x in shares[name])
        axes.text(2e6, place, f"{wrong} wrong, {failed[name]} failed of {runs}", va="center", fontsize=8)
    axes.axvline(100, color="black", linewidth=0.8)
    axes.axvline(1, color="#bbbbbb", linewidth=0.8, zorder=0)
    axes.set(xscale="log", xlim=(1e-6, 1e6), ylim=(-0.7, len(names) - 0.3),
             xlabel="error of a run that said success, in units of κ·rtol (right of the line: a wrong success)")
    axes.set_yticks(range(len(names)), list(reversed(names)), fontsize=8)
    path = pathlib.Path(sys.argv[2])
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=80, bbox_inches="tight")


if __name__ == "__main__":
    main()
