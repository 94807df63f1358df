"""A slice through crystal and liquid, g(r) of both, temperature and energies: argon_melt*.csv and .xyz to argon_melt.png."""
import numpy

from style import BLUE, GREEN, GREY, ORANGE, RED, frames, plt, read, save

rows, shells, moments = read("argon_melt.csv"), read("argon_melt_gr.csv"), list(frames("argon_melt.xyz"))
sigma, tau = 3.405, 2.156
figure, axes = plt.subplots(1, 4, figsize=(20, 4.9), layout="constrained", gridspec_kw={"width_ratios": (1, 1, 1.05, 1.15)})

for panel, (time, columns), name in zip(axes, (moments[0], moments[-1]), ("the crystal", "the liquid")):
    r = sigma * columns["pos"]
    size = sigma * (moments[0][1]["pos"].max() + 0.5 * 1.68)
    slab = r[r[:, 2] < 0.8 * sigma]
    slab = slab[numpy.argsort(slab[:, 2])]
    panel.scatter(slab[:, 0], slab[:, 1], s=(300 / size * 3.4) ** 2 / 2.6, c=slab[:, 2], cmap="Blues", vmin=-3,
                  edgecolors="#123", linewidths=0.4)
    panel.set(xlim=(0, size), ylim=(0, size), aspect="equal", xlabel="x [Å]", ylabel="y [Å]",
              title=f"{name}: a slice at t = {tau * time:.1f} ps")
    panel.grid(False)

times = sorted({row["t_ps"] for row in shells})
for time, colour, label in ((times[0], GREY, "crystal (clipped)"), (times[-1], BLUE, f"{times[-1]:.1f} ps: liquid")):
    own = [row for row in shells if row["t_ps"] == time]
    axes[2].plot([row["r_A"] for row in own], [row["g"] for row in own], color=colour, label=label,
                 linewidth=0.8 if colour == GREY else 2.2, alpha=0.7 if colour == GREY else 1)
axes[2].axhline(1, color="black", linewidth=0.7)
axes[2].set(xlabel="r [Å]", ylabel="g(r)", ylim=(0, 3.6), xlim=(2, 17), title="radial distribution")
axes[2].legend(loc="upper right", frameon=True, framealpha=1, edgecolor="none")

t = [row["t_ps"] for row in rows]
axes[3].plot(t, [row["temperature_K"] for row in rows], color=RED)
axes[3].axhline(83.8, color="black", linestyle="--", linewidth=1)
axes[3].annotate("argon's triple point, 83.8 K", (0.98, 83.8), xycoords=("axes fraction", "data"), xytext=(0, -14),
                 textcoords="offset points", ha="right", fontsize=9.5)
axes[3].set(xlabel="t [ps]", ylabel="temperature [K]", ylim=(60, 185), title="temperature; energies per atom")
inset = axes[3].inset_axes((0.42, 0.5, 0.56, 0.44))
for key, colour in (("kinetic", ORANGE), ("potential", GREEN), ("energy", "black")):
    inset.plot(t, [row[key] for row in rows], color=colour, linewidth=1.4)
    inset.annotate(key if key != "energy" else "total", (t[-1], rows[-1][key]), xytext=(-4, 4), ha="right", fontsize=9,
                   textcoords="offset points", color=colour)
inset.set_ylabel("[ε]", fontsize=9)
save(figure, "argon_melt.png")
