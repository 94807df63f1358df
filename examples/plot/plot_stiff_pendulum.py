"""The stiff pendulum: error of the angle over Δt, and energy over time at Δt = 10 ms."""
from style import BLUE, GREY, RED, plt, read, save

errors, energies = read("stiff_pendulum_error.csv"), read("stiff_pendulum_energy.csv")
figure, (left, right) = plt.subplots(1, 2, figsize=(10.5, 4.4), layout="constrained")
schemes = (("verlet", "Verlet", GREY, "s-"), ("split", "rod φ = ½, gravity φ = 0", BLUE, "o-"),
           ("damped", "rod φ = 1, gravity φ = 0", RED, "^-"))

for name, label, colour, style in schemes:
    known = [row for row in errors if row[f"{name}_rad"] == row[f"{name}_rad"]]
    left.loglog([1e3 * r["dt_s"] for r in known], [r[f"{name}_rad"] for r in known], style, color=colour, label=label)
left.axvline(2, color=GREY, linestyle=":", linewidth=1.2)
left.annotate("Verlet's limit 2/ω", (1.9, 0.12), color=GREY, fontsize=10, ha="right")
left.set(xlabel="Δt [ms]", ylabel="error of the angle after 4 s [rad]", title="Error")
left.legend(fontsize=10)

for name, label, colour, _ in schemes[1:]:
    rows = [row for row in energies if row["scheme"] == name and row["dt_s"] == 0.01]
    right.plot([r["t_s"] for r in rows], [100 * r["energy_error"] for r in rows], color=colour, label=label)
right.set(xlabel="t [s]", ylabel="energy error [%]", title="Energy at Δt = 10 ms")
right.legend(fontsize=10)
save(figure, "stiff_pendulum.png")
