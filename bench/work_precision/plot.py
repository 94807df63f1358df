#!/usr/bin/env python3
"""Time against error, one picture a problem, from what bench_work_precision wrote.

    python3 bench/work_precision/plot.py [DIR, default out]     reads DIR/work_precision.csv, writes DIR/work_precision_*.png
"""
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "examples" / "plot"))
import style  # noqa: E402
from style import plt  # noqa: E402

TITLES = {
    "hires": "HIRES: eight reactions", "robertson": "Robertson to t = 40",
    "van_der_pol": "Van der Pol, ε = 1e-6", "kepler": "Kepler, e = 0.6, five periods",
    "brusselator_1d": "Brusselator with diffusion, 500 points", "heat_2d": "Heat on 64 × 64 points",
    "spring_network": "Stretched net of 20 × 20 masses, stiff damped springs",
}
# phistep's schemes by colour, controlled runs solid, fixed steps dotted; the rivals in grey.
OURS = {"forward Euler": style.ORANGE, "backward Euler": style.RED, "trapezoidal": style.BLUE, "TR-BDF2": style.GREEN,
        "velocity Verlet": style.PURPLE}
MARKERS = "osD^v<>ph"


def front(points):
    """The runs that no other run of the same method beats in both error and time."""
    kept, best = [], float("inf")
    for seconds, error in sorted((p["seconds"], p["error"]) for p in points):
        if error < best:
            kept.append((error, seconds))
            best = error
    return kept


def look(method, rivals):
    scheme = method.replace(", fixed dt", "")
    if scheme in OURS:
        fixed = scheme != method
        return {"color": OURS[scheme], "linestyle": ":" if fixed else "-", "marker": "." if fixed else "o",
                "markersize": 4, "zorder": 2 if fixed else 3}
    shade = {"CVODE": "black", "ARKODE": "#888888"}.get(method.split()[0], style.GREY)
    return {"color": shade, "linestyle": "--", "linewidth": 1.2, "marker": MARKERS[rivals.index(method) % len(MARKERS)],
            "markersize": 4, "zorder": 1}


def main():
    rows = style.read("work_precision.csv")
    for problem in dict.fromkeys(row["problem"] for row in rows):
        of_problem = [row for row in rows if row["problem"] == problem]
        methods = list(dict.fromkeys(row["method"] for row in of_problem))
        rivals = [m for m in methods if m.replace(", fixed dt", "") not in OURS]
        figure, axes = plt.subplots(figsize=(7.2, 5))
        for method in methods:
            points = front([row for row in of_problem if row["method"] == method])
            axes.loglog([e for e, _ in points], [1e3 * s for _, s in points], label=method, **look(method, rivals))
        axes.invert_xaxis()
        axes.axvline(1e-3, color="#bbbbbb", linewidth=1, zorder=0)
        axes.set(xlabel="error at the end, max |y − exact| / (|exact| + a)", ylabel="CPU time, set-up included [ms]",
                 title=TITLES.get(problem, problem))
        axes.legend(fontsize=8, loc="center left", bbox_to_anchor=(1, 0.5))
        style.save(figure, f"work_precision_{problem}.png")
        plt.close(figure)


if __name__ == "__main__":
    main()
