"""Arenstorf's orbit with every tenth step marked, and the step over time."""
from style import BLUE, GREY, RED, plt, read, save

orbit, steps = read("arenstorf_orbit.csv"), read("arenstorf_steps.csv")
figure, (left, right) = plt.subplots(1, 2, figsize=(10.5, 4.4), layout="constrained")

left.plot([r["x"] for r in orbit], [r["y"] for r in orbit], color=BLUE, linewidth=1.2)
left.plot([r["x"] for r in steps[::10]], [r["y"] for r in steps[::10]], ".", color=RED, markersize=3,
          label="every tenth step")
left.plot([-0.012277471], [0], "o", color=GREY, markersize=9)
left.plot([1 - 0.012277471], [0], "o", color=GREY, markersize=5)
left.annotate("earth", (-0.012, 0.08), color=GREY, fontsize=10, ha="center")
left.annotate("moon", (1.02, 0.06), color=GREY, fontsize=10)
left.set(xlabel="x [earth-moon distances]", ylabel="y", title="One period", aspect="equal")
left.legend(fontsize=10, loc="upper right")

right.semilogy([r["t"] for r in steps], [r["dt"] for r in steps], color=BLUE, linewidth=1.2)
right.set(xlabel="t [months / 2π]", ylabel="Δt", title="The step it takes, rtol = 1e-6")
save(figure, "arenstorf.png")
