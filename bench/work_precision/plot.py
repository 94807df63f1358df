#!/usr/bin/env python3
"""Time against error, one picture a problem, from what bench_work_precision wrote.

    python3 bench/work_precision/plot.py [DIR, default out]     reads DIR/work_precision.csv, writes DIR/work_precision_*.png
"""
import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "examples" / "plot"))
import style  # noqa: E402
from style import plt  # noqa: E402

# phistep's schemes in colours that stay theirs, fixed steps dotted; of each rival library the front of all its methods.
COLOURS = [style.GREEN, style.BLUE, style.RED, style.PURPLE, style.ORANGE, "#17a3a3", "#a3174f", "#7a7a00"]
RIVALS = {"CVODE": ("black", "o"), "ARKODE": ("#777777", "s"), "Odeint": ("#b08968", "D"), "GSL": ("#9fb3c8", "^"),
          "PETSc": ("#c9c9c9", "v")}


def front(points, error):
    """The runs that no other beats in both error and time."""
    kept, best = [], float("inf")
    for point in sorted(points, key=lambda p: p["seconds"]):
        if point["seconds"] > 0 and math.isfinite(point[error]) and point[error] < best:
            best = point[error]
            kept.append((max(best, 1e-16), 1e6 * point["seconds"]))
    return kept


def draw(axes, rows, error):
    rivals = [row for row in rows if row["library"] != "phistep"]
    for library, (colour, marker) in RIVALS.items():
        line = front([row for row in rivals if row["library"] == library], error)
        if line:
            axes.loglog(*zip(*line), label=library, color=colour, marker=marker, markersize=3.5, linestyle="--",
                        linewidth=1.2, zorder=1)
    ours = list(dict.fromkeys(row["method"].replace(", fixed dt", "") for row in rows if row["library"] == "phistep"))
    for method in dict.fromkeys(row["method"] for row in rows if row["library"] == "phistep"):
        scheme = method.replace(", fixed dt", "")
        line = front([row for row in rows if row["method"] == method], error)
        if line:
            axes.loglog(*zip(*line), label=method, color=COLOURS[ours.index(scheme) % len(COLOURS)],
                        linestyle="-" if scheme == method else ":", marker=".", markersize=5, zorder=3)
    for wanted in (1e-3, 1e-6, 1e-9):
        axes.axvline(wanted, color="#bbbbbb", linewidth=1, zorder=0)


def main():
    rows = style.read("work_precision.csv")
    for problem in dict.fromkeys(row["problem"] for row in rows):
        of_problem = [row for row in rows if row["problem"] == problem]
        over_time = any(math.isfinite(row["largest_error"]) for row in of_problem)
        figure, both = plt.subplots(1, 2 if over_time else 1, figsize=(11 if over_time else 6, 5), sharey=True, squeeze=False)
        draw(both[0][0], of_problem, "error")
        both[0][0].set(xlabel="error at the end: max |y − exact| / (|exact| + a)", ylabel="CPU time, set-up included [µs]",
                       title=of_problem[0]["title"])
        if over_time:
            draw(both[0][1], of_problem, "largest_error")
            both[0][1].set(xlabel="largest error over 100 log-spaced times")
        for axes in both[0]:
            axes.invert_xaxis()
        both[0][-1].legend(fontsize=8, loc="center left", bbox_to_anchor=(1, 0.5))
        style.save(figure, f"work_precision_{problem}.png")
        plt.close(figure)


if __name__ == "__main__":
    main()
