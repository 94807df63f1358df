"""The struck beam: the tip's velocity in the last of five periods, half of it, by four schemes."""
from style import BLUE, GREEN, GREY, RED, plt, read, save

rows = read("struck_beam.csv")
end = max(row["t_s"] for row in rows)
figure, axes = plt.subplots(1, 3, figsize=(11, 3.5), layout="constrained")
schemes = (("trapezoidal", "trapezoidal, φ = ½", GREY), ("backward_euler", "backward_euler, φ = 1", RED),
           ("generalized_alpha(0.5)", "generalized_alpha(0.5)", BLUE))
for axis, (name, label, colour) in zip(axes, schemes):
    last = [row for row in rows if row["scheme"] == name and row["t_s"] > end * 0.9]
    time = [1e3 * row["t_s"] for row in last]
    axis.plot(time, [row["v_m_s"] for row in last], color=colour, linewidth=0.7, label=label)
    axis.plot(time, [row["wanted_m_s"] for row in last], color=GREEN, linestyle="--", label="first three modes, exact")
    axis.set(xlabel="t [ms]", ylim=(-0.4, 0.4))
    axis.legend(fontsize=9, loc="upper left")
axes[0].set(ylabel="velocity of the tip [m/s]", title="Noise of 13 m/s, cut off")
axes[1].set(title="No noise, little motion")
axes[2].set(title="The motion, and the next modes")
save(figure, "struck_beam.png")
