"""The plate after three steps of φ = ½, without and with two backward Euler half steps first: heat_field.csv to heat.png."""
import matplotlib.colors

from style import BLUE, GREY, RED, plt, read, save

rows = read("heat_field.csv")
n = round(len(rows) ** 0.5)
centimetres = [100 * row["x_m"] for row in rows[:n]]


def field(key):
    return [[row[key] for row in rows[n * j:n * (j + 1)]] for j in range(n)]


ringing, cured, k = field("theta_phi_half_K"), field("theta_rannacher_K"), field("k_W_per_mK")
figure, (left, middle, right) = plt.subplots(1, 3, figsize=(15, 4.6), layout="constrained",
                                             gridspec_kw={"width_ratios": (1, 1, 1.15)})
colours = plt.get_cmap("inferno").with_extremes(under="deepskyblue")
norm = matplotlib.colors.Normalize(0, max(map(max, ringing)))
for axes, values, title in ((left, ringing, "φ = ½ alone: rings"), (middle, cured, "two half steps of φ = 1 first")):
    axes.grid(False)
    mesh = axes.pcolormesh(centimetres, centimetres, values, cmap=colours, norm=norm, shading="nearest")
    axes.contour(centimetres, centimetres, k, levels=[200], colors="white", linewidths=0.8, linestyles="--")
    axes.set(xlabel="x [cm]", ylabel="y [cm]", title=title, aspect="equal")
figure.colorbar(mesh, ax=[left, middle], label="θ above the edges [K]; blue: below 0", extend="min", shrink=0.95)
steel = [x for x, conductivity in zip(centimetres, k[0]) if conductivity < 200]
right.axvspan(steel[0], steel[-1], color=GREY, alpha=0.15, linewidth=0)
right.text(steel[-1] + 0.15, 0.45, "steel", ha="left", color=GREY, transform=right.get_xaxis_transform())
right.plot(centimetres, ringing[n // 2], color=RED, label="φ = ½ alone")
right.plot(centimetres, cured[n // 2], color=BLUE, label="two half steps of φ = 1 first")
right.axhline(0, color="black", linewidth=0.8)
right.set(xlabel="x [cm]", ylabel="θ above the edges [K]", title="along the middle, after three steps")
low, high = right.get_ylim()
right.set_ylim(low, low + 1.3 * (high - low))
right.legend(loc="upper right")
save(figure, "heat.png")
