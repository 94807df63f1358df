#!/usr/bin/env python3
"""Energy errors against the number of steps: a drift (∝ n), a random walk (∝ √n), a bounded swing.

    PHISTEP_SERIES=$PWD/series cmake --workflow --preset stress      writes the series
    python3 bench/stability/plot_endurance.py series docs/images/endurance.png
"""
import csv
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

U = 2.0**-53

# file, label, colour: the left panel is linear, what rounding alone does; the right one are problems of mechanics.
LEFT = [
    ("affine midpoint, a = 1e+03", "affine midpoint, ωΔt = 1000: 1/W rounds alike each step", "#b2182b"),
    ("midpoint by Newton, a = 0.7", "midpoint by Newton, ωΔt = 0.7", "#ef8a62"),
    ("trapezoidal, stiff, a = 30", "affine trapezoidal, ωΔt = 30", "#4393c3"),
    ("midpoint, stiff, a = 3", "affine midpoint, ωΔt = 3", "#2166ac"),
    ("trapezoidal, a = 0.1", "affine trapezoidal, ωΔt = 0.1", "#053061"),
    ("Verlet, its own energy, a = 0.1", "Verlet, its own energy", "#1b7837"),
    ("midpoint, float, stiff, a = 3", "affine midpoint in float, ωΔt = 3", "#999999"),
]
RIGHT = [
    ("Verlet, energy", "Kepler, Verlet", "#7fbf7b"),
    ("Verlet, argon", "seven argon atoms, Verlet", "#1b7837"),
    ("SRKN6b, energy", "Kepler, SRKN6b", "#67a9cf"),
    ("SRKN11b, energy", "Kepler, SRKN11b", "#2166ac"),
    ("SRKN11b, 75 d, energy", "outer planets, SRKN11b, 75 d", "#053061"),
    ("RKN12(10), 200 d, energy", "outer planets, RKN12(10), 200 d", "#b2182b"),
    ("RKN12(10), 200 d, compensated, energy", "… with compensated sums", "#f4a582"),
]


def running_max(path):
    with open(path, newline="") as f:
        rows = [(int(r["steps"]), abs(float(r["error"]))) for r in csv.DictReader(f)]
    n, most, out = [], 0.0, []
    for steps, error in rows:
        most = max(most, error)
        if most > 0:
            n.append(steps)
            out.append(most)
    return n, out


def draw(axes, folder, series, title):
    for name, label, colour in series:
        path = folder / f"{name}.csv"
        if path.exists():
            axes.loglog(*running_max(path), color=colour, lw=1.6, label=label)
        else:
            print(f"no {path}", file=sys.stderr)
    n = [1, 1e8]
    axes.loglog(n, [2 * U * x for x in n], color="k", lw=0.7, ls=":")
    axes.loglog(n, [2 * U * x**0.5 for x in n], color="k", lw=0.7, ls="--")
    axes.text(1e7, 2 * U * 1e7 * 2.5, "∝ n: drift", fontsize=7, rotation=18, rotation_mode="anchor")
    axes.text(3e6, 2 * U * 3e6**0.5 / 12, "∝ √n: random walk", fontsize=7, rotation=9, rotation_mode="anchor")
    axes.set_title(title, fontsize=10)
    axes.set_xlabel("steps")
    axes.set_xlim(1, 1e8)
    axes.set_ylim(1e-17, 1e3)
    axes.grid(alpha=0.25, lw=0.5)
    axes.legend(fontsize=6.5, loc="upper left", framealpha=0.9)


def main():
    folder, out = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.8), sharey=True)
    draw(left, folder, LEFT, "the harmonic oscillator: what rounding alone does")
    draw(right, folder, RIGHT, "orbits and atoms")
    left.set_ylabel("largest |ΔE/E| so far")
    figure.tight_layout()
    out.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(out, dpi=110)


if __name__ == "__main__":
    main()
