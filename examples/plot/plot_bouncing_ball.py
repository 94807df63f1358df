"""The bouncing ball: its path, and how the bounces pile up before Zeno's time."""
from style import BLUE, GREY, RED, plt, read, save

path, times = read("bouncing_ball_path.csv"), read("bouncing_ball_times.csv")
figure, (left, right) = plt.subplots(1, 2, figsize=(10.5, 4.4), layout="constrained")

left.plot([row["x_m"] for row in path], [row["y_m"] for row in path], color=BLUE)
left.axhline(0, color=GREY, linewidth=1.2)
left.set(xlabel="x [m]", ylabel="y [m]", title="Path")

zeno = times[-1]["formula_s"] + 9 * (times[-1]["formula_s"] - times[-2]["formula_s"])  # e/(1 − e) = 9 flights more
right.semilogy([row["bounce"] for row in times], [zeno - row["t_s"] for row in times], ".", color=BLUE,
               label="T − t, T Zeno's time")
right.semilogy([row["bounce"] for row in times],
               [max(abs(row["t_s"] - row["formula_s"]), 1e-16) for row in times], ".", color=RED, label="error of t")
right.set(xlabel="bounce", ylabel="[s]", title="Bounces")
right.legend(fontsize=10)
save(figure, "bouncing_ball.png")
