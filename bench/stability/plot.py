#!/usr/bin/env python3
"""The atlas of stability, from what bench_stability measured.

    python3 bench/stability/plot.py [DIR, default out]     reads DIR/stability_*.csv, writes DIR/stability_*.png
"""
import math
import pathlib
import sys

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "examples" / "plot"))
import style  # noqa: E402
from style import plt  # noqa: E402

LEVELS = [1e-3, 1e-2, 1e-1, 0.5, 2, 10]
COLOURS = [style.BLUE, style.RED, style.GREEN, style.ORANGE, style.PURPLE, "#17a3a3", "#a3174f", "#7a7a00", "#666666",
           "#b08968", "#1fb4a0", "#c8b400", "#333333", "#d46fb4"]


def by_scheme(rows):
    return {name: [row for row in rows if row["scheme"] == name] for name in dict.fromkeys(row["scheme"] for row in rows)}


def regions():
    schemes = by_scheme(style.read("stability_regions.csv"))
    figure, panels = plt.subplots(3, 4, figsize=(13, 10.2))
    for axes, (name, rows) in zip(panels.flat, schemes.items()):
        re, im = sorted({row["re"] for row in rows}), sorted({row["im"] for row in rows})
        R = numpy.array([row["amplification"] for row in rows]).reshape(len(re), len(im)).T
        R, im = numpy.vstack([R[::-1], R]), [-y for y in reversed(im)] + im
        R = numpy.clip(numpy.nan_to_num(R, nan=1e9), 1e-12, 1e9)
        axes.contourf(re, im, R, levels=[0, 1], colors=["#cfe3f5"])
        lines = axes.contour(re, im, R, levels=LEVELS, colors="#8899aa", linewidths=0.7)
        axes.clabel(lines, fmt="%g", fontsize=6.5)
        axes.contour(re, im, R, levels=[1], colors=style.BLUE, linewidths=1.8)
        axes.axhline(0, color="#444444", linewidth=0.7)
        axes.axvline(0, color="#444444", linewidth=0.7)
        axes.set_title(name, fontsize=10)
        axes.set_aspect("equal")
        axes.grid(False)
        axes.tick_params(labelsize=8)
    for axes in panels[-1]:
        axes.set_xlabel("Re λΔt", fontsize=9)
    for axes in panels[:, 0]:
        axes.set_ylabel("Im λΔt", fontsize=9)
    figure.suptitle("One step of y' = λy, measured: stable where shaded, |y⁺/y| ≤ 1; lines of equal |y⁺/y|", fontsize=12)
    figure.tight_layout()
    figure.set_dpi(78)
    plt.rcParams["savefig.dpi"] = 78  # many lines: a small file
    style.save(figure, "stability_regions.png")
    plt.rcParams["savefig.dpi"] = "figure"


def along_axes():
    schemes = by_scheme(style.read("stability_axes.csv"))
    figure, both = plt.subplots(1, 2, figsize=(13, 4.8), sharey=True)
    for axes, axis, label in ((both[0], "real", "−λΔt, decay"), (both[1], "imaginary", "|λ|Δt, oscillation")):
        for colour, (name, rows) in zip(COLOURS, schemes.items()):
            line = [row for row in rows if row["axis"] == axis]
            axes.loglog([row["size"] for row in line], [max(row["amplification"], 1e-9) for row in line], label=name,
                        color=colour, linewidth=1.5)
        exact = [row["size"] for row in line]
        axes.loglog(exact, [max(math.exp(-x), 1e-9) if axis == "real" else 1 for x in exact], color="black", linestyle=":",
                    linewidth=1.6, label="exact")
        axes.set(xlabel=label, ylim=(1e-7, 1e2))
        axes.axhline(1, color="#bbbbbb", linewidth=0.8, zorder=0)
    both[0].set_ylabel("|y⁺/y|")
    both[1].legend(fontsize=8, loc="center left", bbox_to_anchor=(1, 0.5))
    figure.suptitle("One step along the axes: what is not resolved is damped, kept or blown up", fontsize=12)
    style.save(figure, "stability_axes.png")


def motion():
    schemes = by_scheme(style.read("stability_motion.csv"))
    figure, axes = plt.subplots(figsize=(9.5, 5))
    for colour, (name, rows) in zip(COLOURS, schemes.items()):
        axes.semilogx([row["a"] for row in rows], [min(row["radius"], 9) for row in rows], label=name, color=colour,
                      linewidth=1.7)
    axes.set(xlabel="ωΔt", ylabel="spectral radius of a step", ylim=(-0.03, 1.75), xlim=(0.1, 300),
             title="An undamped oscillation: above 1 it grows, below it is damped, at 1 it stays")
    axes.axhline(1, color="#bbbbbb", linewidth=0.8, zorder=0)
    axes.legend(fontsize=8.5, loc="center left", bbox_to_anchor=(1, 0.5))
    style.save(figure, "stability_motion.png")


def pairs():
    rows = style.read("stability_pairs.csv")
    force, drift = sorted({row["phi_force"] for row in rows}), sorted({row["phi_drift"] for row in rows})
    limit = numpy.array([row["limit"] for row in rows]).reshape(len(force), len(drift))
    figure, axes = plt.subplots(figsize=(6.6, 5.4))
    shown = numpy.where(numpy.isinf(limit), 1e3, limit)
    levels = [1e-9, 1, 2, 2.5, 3, 4, 6, 10, 900, 1e4]
    colours = ["#fbe3d4", "#f7c9a9", "#f0a35e", "#e6b85c", "#d9d26a", "#b6d17a", "#8cc48c", "#62b3a3", "#5b9fd0"]
    axes.contourf(drift, force, shown, levels=levels, colors=colours)
    axes.contour(drift, force, shown, levels=[1e-9, 900], colors="#333333", linewidths=0.9)
    lines = axes.contour(drift, force, numpy.where(shown > 900, numpy.nan, shown), levels=[3, 4, 6], colors="#555555",
                         linewidths=0.7)
    axes.clabel(lines, fmt="%g", fontsize=8)
    axes.text(0.26, 0.2, "never stable:\nenergy grows", ha="center", fontsize=10)
    axes.text(0.74, 0.84, "stable at any ωΔt", ha="center", fontsize=10, color="white")
    for x, y, name, dx, dy, align in ((0, 0, "forward_euler", 8, 6, "left"), (0.5, 0.5, "trapezoidal, midpoint", 8, -14, "left"),
                               (1, 1, "backward_euler", -8, -14, "right"), (1, 0, "symplectic_euler", -8, 8, "right"),
                               (0, 1, "symplectic_euler_adjoint", 8, -14, "left")):
        axes.plot([x], [y], "o", color="black", markersize=5, clip_on=False, zorder=5)
        axes.annotate(name, (x, y), xytext=(dx, dy), textcoords="offset points", fontsize=8.5, ha=align)
    axes.set(xlabel="φ drift", ylabel="φ force", title="Pairs: the largest ωΔt at which no undamped\noscillation grows")
    axes.set_aspect("equal")
    axes.grid(False)
    style.save(figure, "stability_pairs.png")


if __name__ == "__main__":
    regions()
    along_axes()
    motion()
    pairs()
