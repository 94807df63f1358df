#!/usr/bin/env python3
"""Pictures of what bench_particles wrote.

    python3 bench/particles/plot.py [DIR, default out]     reads DIR/particles*.csv, writes DIR/particles_*.png
"""
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "examples" / "plot"))
import style  # noqa: E402
from style import plt  # noqa: E402

COLOURS = {"forward Euler": style.ORANGE, "backward Euler": style.RED, "trapezoidal": style.BLUE,
           "TR-BDF2": style.GREEN, "velocity Verlet": style.PURPLE}
LABELS = {"forward Euler": "φ = 0, forward Euler", "trapezoidal": "φ = ½, trapezoidal",
          "backward Euler": "φ = 1, backward Euler"}
RATES = {"melt": "Lennard-Jones melt", "grains": "Grains down a chute", "springs": "Spring sheet",
         "gravity": "Softened gravity", "gravity, float": "Softened gravity, float",
         "skipping": "Grains at rest"}


def rows_of(name):
    return style.read(name) if (style.out / name).exists() else []


def bars(rows, row):
    """Rates as bars: phistep in blue, the others in grey; one picture of the largest scene."""
    rates = [r for r in rows if r["row"] == row and r["quantity"] == "rate"]
    if not rates:
        return
    most = max(r["particles"] for r in rates)
    rates = [r for r in rates if r["particles"] == most or row == "skipping"]
    figure, axes = plt.subplots(figsize=(7.2, 0.5 + 0.32 * len(rates)))
    names = [r["name"] + (f", {r['threads']:.0f} threads" if r["threads"] > 1 else "") for r in rates]
    axes.barh(range(len(rates)), [r["value"] for r in rates],
              color=[style.BLUE if "phistep" in n or row == "skipping" else style.GREY for n in names])
    axes.set_yticks(range(len(rates)), names, fontsize=9)
    axes.invert_yaxis()
    axes.grid(False, axis="y")
    axes.set(xlabel=rates[0]["unit"], title=f"{RATES[row]}, {most:,.0f} particles")
    style.save(figure, f"particles_{row.replace(', ', '_')}.png")
    plt.close(figure)


def sizes(rows):
    """Time and memory an atom, from a thousand atoms to a million."""
    rows = [r for r in rows if r["row"] == "sizes"]
    if not rows:
        return
    figure, pair = plt.subplots(1, 2, figsize=(9.5, 3.6))
    for axes, quantity in zip(pair, ("time", "memory")):
        for who, colour in (("phistep", style.BLUE), ("LAMMPS", style.GREY)):
            some = [r for r in rows if r["quantity"] == quantity and r["name"].startswith(who)]
            if some:
                axes.semilogx([r["particles"] for r in some], [r["value"] for r in some], marker="o", color=colour,
                              label=who)
        axes.set(xlabel="atoms", ylabel={"time": "ns an atom-step", "memory": "bytes an atom"}[quantity], ylim=(0, None))
        axes.legend()
    pair[1].set_ylim(0, 2000)
    figure.suptitle("Lennard-Jones melt")
    figure.tight_layout()
    style.save(figure, "particles_sizes.png")
    plt.close(figure)


def ladders(name, quantity, label, title, file):
    """CPU time against error or energy, a curve a method, a panel a scene."""
    rows = rows_of(f"particles_{name}.csv")
    if not rows:
        return
    scenes = list(dict.fromkeys(row["scene"] for row in rows))
    figure, panels = plt.subplots(1, len(scenes), figsize=(3.4 + 3.0 * len(scenes), 4.2), sharey=True, squeeze=False)
    for axes, scene in zip(panels[0], scenes):
        for method in dict.fromkeys(row["method"] for row in rows):
            points = [r for r in rows if r["scene"] == scene and r["method"] == method]
            axes.loglog([r[quantity] for r in points], [1e3 * r["seconds"] for r in points], marker="o", markersize=4,
                        color=COLOURS[method], label=LABELS.get(method, method))
        axes.invert_xaxis()
        axes.set(xlabel=label, title=title if len(scenes) == 1 else f"{title}, {scene}")
    panels[0][0].set_ylabel("CPU time [ms]")
    panels[0][-1].legend(fontsize=8, loc="center left", bbox_to_anchor=(1, 0.5))
    style.save(figure, file)
    plt.close(figure)


def main():
    rows = rows_of("particles.csv")
    for row in RATES:
        bars(rows, row)
    sizes(rows)
    ladders("drift", "error", "error of positions / σ", "Seven argon atoms", "particles_error.png")
    ladders("drift", "drift", "largest |ΔH|/k_B [K]", "Seven argon atoms", "particles_energy.png")
    ladders("bonded", "error", "error of the tip's path", "Beam", "particles_bonded.png")


if __name__ == "__main__":
    main()
