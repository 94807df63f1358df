"""The cluster at its start and its end, Lagrangian radii, the energy's error: plummer.csv and plummer.xyz to plummer.png."""
import math

import numpy

from style import BLUE, GREEN, GREY, ORANGE, PURPLE, RED, frames, plt, read, save

rows, moments = read("plummer.csv"), list(frames("plummer.xyz"))
core = 3 * math.pi / 16
figure, axes = plt.subplots(1, 4, figsize=(20, 4.9), layout="constrained", gridspec_kw={"width_ratios": (1, 1, 1.2, 1.1)})

for panel, (time, columns) in zip(axes, (moments[0], moments[-1])):
    x, y, z = columns["pos"].T
    order = numpy.argsort(z)
    speed = numpy.linalg.norm(columns["velo"], axis=1)
    dots = panel.scatter(x[order], y[order], s=7 + 3 * (z[order] > 0), c=speed[order], cmap="plasma", vmin=0, vmax=1.6, linewidths=0)
    panel.set(xlim=(-2.6, 2.6), ylim=(-2.6, 2.6), aspect="equal", xlabel="x", ylabel="y", facecolor="#0b0b18",
              title=f"t = {time / math.sqrt(8):.0f} crossing times")
    panel.grid(False)
bar = figure.colorbar(dots, ax=axes[1], shrink=0.9)
bar.set_label("speed")

t = [row["t"] / math.sqrt(8) for row in rows]
for key, colour in (("r10", RED), ("r25", ORANGE), ("r50", GREEN), ("r75", BLUE), ("r90", PURPLE)):
    share = int(key[1:]) / 100
    theory = core / math.sqrt((0.999 * share) ** (-2 / 3) - 1)
    axes[2].semilogy(t, [row[key] for row in rows], color=colour, linewidth=1.6)
    axes[2].plot((t[0], t[-1]), (theory, theory), color=colour, linestyle="--", linewidth=1)
    axes[2].annotate(f"{key[1:]} %", (t[-1], theory), xytext=(5, -4), textcoords="offset points", color=colour, fontsize=10)
axes[2].set_yticks([0.2, 0.5, 1, 2], ["0.2", "0.5", "1", "2"])
axes[2].set_yticks([], minor=True)
axes[2].set(xlabel="t [crossing times]", ylabel="radius with so much of the mass", title="Lagrangian radii (dashed: Plummer)")

axes[3].plot(t, [1e3 * row["energy_error"] for row in rows], color=GREY)
axes[3].axhline(0, color="black", linewidth=0.8)
axes[3].set(xlabel="t [crossing times]", ylabel="1000 (E/E₀ − 1)", title="error of the energy")
figure.get_layout_engine().set(wspace=0.05)
save(figure, "plummer.png")
