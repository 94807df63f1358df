"""Error against Δt of the throw, and the orbit and energy of the mass on a spring: point_mass*.csv to point_mass.png."""
import math

from style import BLUE, GREEN, GREY, RED, plt, read, save

names = {0.0: ("φ = 0, forward Euler", RED), 0.5: ("φ = ½, trapezoidal", BLUE), 1.0: ("φ = 1, backward Euler", GREEN)}
errors, orbit = read("point_mass_error.csv"), read("point_mass_orbit.csv")
figure, (left, middle, right) = plt.subplots(1, 3, figsize=(15, 4.6), layout="constrained")

for phi, (name, colour) in names.items():
    rows = [row for row in errors if row["phi"] == phi]
    left.loglog([r["dt_s"] for r in rows], [r["error_m"] for r in rows], "o-" if phi else "s-", color=colour, label=name)
    rows = [row for row in orbit if row["phi"] == phi]
    middle.plot([r["x_m"] for r in rows], [r["y_m"] for r in rows], color=colour, label=name)
    right.semilogy([r["t_s"] for r in rows], [r["energy_J"] / rows[0]["energy_J"] for r in rows], color=colour, label=name)

dts = sorted({row["dt_s"] for row in errors})
for order, at in ((1, 2.2), (2, 0.25)):
    left.loglog(dts, [at * (dt / dts[-1]) ** order for dt in dts], ":", color=GREY)
    left.annotate(f"slope {order}", (dts[2], at * (dts[2] / dts[-1]) ** order), xytext=(-4, 6), textcoords="offset points",
                  color=GREY, ha="right")
left.set(xlabel="Δt [s]", ylabel="distance from the exact landing point [m]", title="The throw: order of convergence")
left.set_xticks(dts, [f"{dt:g}" for dt in dts])
left.minorticks_off()
left.legend(loc="lower right")

circle = [2 * math.pi * k / 200 for k in range(201)]
middle.plot([math.cos(c) for c in circle], [math.sin(c) for c in circle], "--", color="black", linewidth=1.2, label="exact")
middle.set(xlabel="x [m]", ylabel="y [m]", title="The spring: five rounds", aspect="equal")
right.axhline(1, color="black", linestyle="--", linewidth=1.2, label="exact")
right.set(xlabel="t [s]", ylabel="E / E₀ [–]", title="The spring: energy, ωΔt = 0.1")
right.legend(loc="upper left")
save(figure, "point_mass.png")
