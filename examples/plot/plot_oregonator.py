"""The chemical clock with the steps that were taken, and run time against error for each stepper."""
from style import BLUE, GREY, RED, plt, read, save

curve, steps, work = read("oregonator_curve.csv"), read("oregonator_steps.csv"), read("oregonator_work.csv")
figure, (left, right) = plt.subplots(1, 2, figsize=(10.5, 4.4), layout="constrained")

for name, color in (("x", RED), ("y", BLUE), ("z", GREY)):
    left.semilogy([r["t"] for r in curve], [r[name] for r in curve], color=color, linewidth=1.2, label=name)
    left.semilogy([r["t"] for r in steps], [r[name] for r in steps], ".", color=color, markersize=4)
left.set(xlabel="t", ylabel="concentration", title="radau at rtol = 1e-6: steps (dots), dense output (lines)")
left.legend(fontsize=10)

for scheme in dict.fromkeys(r["scheme"] for r in work):
    rows = [r for r in work if r["scheme"] == scheme]
    right.loglog([r["error"] for r in rows], [r["microseconds"] for r in rows], "o-", linewidth=1.2, markersize=4,
                 label=scheme)
right.invert_xaxis()
right.set(xlabel="relative error at the end", ylabel="time [µs]", title="Run time against error")
right.set_ylim(top=6 * right.get_ylim()[1])  # room for the legend
right.legend(fontsize=9, loc="upper right")
save(figure, "oregonator.png")
