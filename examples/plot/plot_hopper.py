"""Sand in the hopper at four moments, discharge against Beverloo's law, energy and contacts: hopper.csv, .xyz to hopper.png."""
import math

import numpy

from style import BLUE, GREEN, GREY, RED, frames, plt, read, save

rows, moments = read("hopper.csv"), [(t, c) for t, c in frames("hopper.xyz") if len(c["pos"]) > 50]
diameter, g = 4.0, 9.81
slot, width, length = (8, 60, 10) if max(row["left"] for row in rows) > 5000 else (5, 20, 4)  # in diameters, as in hopper.cpp
figure = plt.figure(figsize=(19, 8.6), layout="constrained")
above, below = figure.subfigures(2, 1, height_ratios=(1.3, 1))
pictures, panels = above.subplots(1, 4), below.subplots(1, 3)

# Layers are coloured by when they were poured: ids count up.
last = max(columns["id"].max() for _, columns in moments)
for k, panel in enumerate(pictures):
    time, columns = moments[min(round((len(moments) - 1) * (0.12 + 0.29 * k)), len(moments) - 1)]
    x, y, z = columns["pos"].T / diameter * 1e3
    front = numpy.argsort(-y)
    inches = 19 / 4 * 0.93 / (width + 8)
    panel.scatter(x[front], z[front], s=(72 * inches * 2 * columns["radius"][front, 0] / diameter * 1e3) ** 2, c=columns["id"][front, 0] % (last / 5),
                  cmap="YlOrBr", vmin=-last / 8, vmax=last / 4, edgecolors="#40250f", linewidths=0.12)
    for side in (-1, 1):
        panel.plot([side * slot / 2, side * width / 2, side * width / 2], [0, (width - slot) / 2, width * 0.75], color="#333", linewidth=3)
    panel.set(xlim=(-width / 2 - 2, width / 2 + 2), ylim=(-width / 4, width * 0.75), aspect="equal", title=f"t = {time:.1f} s",
              xticks=[], yticks=[])
    panel.set_frame_on(False)

t = numpy.array([row["t_s"] for row in rows])
left = numpy.array([row["left"] for row in rows])
over = max(1, len(t) // 40)
rate = (left[over:] - left[:-over]) / (t[over:] - t[:-over])
panels[0].plot((t[over:] + t[:-over]) / 2, rate, color=BLUE, label="grains leaving a second")
per_d3 = 0.6 / (math.pi / 6)  # grains per diameter cubed in a bed of which they fill 60 %
law = 1.03 * per_d3 * length * (slot - 1.4) ** 1.5 * math.sqrt(g / (diameter * 1e-3))
panels[0].axhline(law, color="black", linestyle="--", linewidth=1.2, label="Beverloo's law")
panels[0].axhspan(0.9 * law, 1.1 * law, color=GREY, alpha=0.15, linewidth=0)
panels[0].set(xlabel="t [s]", ylabel="grains/s", title="discharge", ylim=(0, None))
panels[0].legend(loc="lower center")
panels[1].plot(t, [1e3 * row["kinetic_energy_J"] for row in rows], color=RED)
panels[1].set(xlabel="t [s]", ylabel="[mJ]", title="kinetic energy", ylim=(0, None))
panels[2].plot(t, [row["coordination"] for row in rows], color=GREEN)
panels[2].set(xlabel="t [s]", ylabel="contacts a grain", title="coordination number", ylim=(0, None))
save(figure, "hopper.png")
