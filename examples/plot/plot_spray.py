"""Spray and footprint without and with charges, temperature by size: spray*.csv and .xyz to spray.png."""
import numpy

from style import BLUE, RED, frames, plt, read, save

landed = read("spray_plate.csv")
figure, axes = plt.subplots(1, 4, figsize=(18, 5.4), layout="constrained", gridspec_kw={"width_ratios": (0.8, 0.8, 1, 1)})
figure.get_layout_engine().set(wspace=0.06)
for panel, name, title in zip(axes, ("spray_neutral", "spray_charged"), ("no charges", "charged to 50 %\nof Rayleigh's limit")):
    time, columns = list(frames(f"{name}.xyz"))[-1]
    x, y, z = 100 * columns["pos"].T
    order = numpy.argsort(y)
    dots = panel.scatter(x[order], z[order], s=(columns["radius"][order, 0] * 2e5) ** 2 / 9, c=columns["temperature"][order, 0],
                         cmap="inferno", vmin=20, vmax=90, linewidths=0)
    panel.axhline(-25, color="#bbb", linewidth=4)
    panel.set(xlim=(-7.5, 7.5), ylim=(-25.6, 0.5), xlabel="x [cm]", ylabel="z [cm]", facecolor="#14141f", aspect="equal",
              title=title)
    panel.grid(False)
figure.colorbar(dots, ax=axes[1], label="temperature [°C]", shrink=0.9)

charges = sorted({row["charge"] for row in landed})
bins = numpy.linspace(0, 10, 26)
for charge, colour, label in zip(charges, (BLUE, RED), ("no charges", "charged")):
    own = [row for row in landed if row["charge"] == charge]
    distance = 100 * numpy.hypot([row["x_m"] for row in own], [row["y_m"] for row in own])
    mass = numpy.array([row["radius_m"] for row in own]) ** 3
    per_area = numpy.histogram(distance, bins, weights=mass / mass.sum())[0] / (numpy.pi * (bins[1:] ** 2 - bins[:-1] ** 2))
    axes[2].stairs(100 * per_area, bins, color=colour, linewidth=2, label=label)
    axes[3].scatter([2e6 * row["radius_m"] for row in own], [row["temperature_C"] for row in own], s=3, color=colour, label=label)
axes[2].set(xlabel="distance from the middle of the plate [cm]", ylabel="water [% per cm²]", title="what lands where")
axes[3].set(xlabel="diameter of the drop [μm]", ylabel="temperature on landing [°C]", title="small ones arrive cold")
if landed:
    axes[2].legend(), axes[3].legend(markerscale=4)
save(figure, "spray.png")
