"""The orbits with the ephemeris' own positions, and error against run time: solar_system_*.csv to solar_system.png.

With a second argument the first two panels go there too, as a small picture (examples/images/solar_system.png).
"""
import sys

from style import BLUE, GREEN, GREY, ORANGE, PURPLE, RED, plt, read, save

schemes = {"velocity_verlet": (BLUE, "o"), "midpoint": (GREEN, "s"), "trapezoidal": (PURPLE, "^"),
           "symplectic_euler": (ORANGE, "D"), "backward_euler": (GREY, "v"), "forward_euler": (RED, "x")}
colours = {"Mercury": "#8c8c8c", "Venus": "#d9a441", "EarthMoon": BLUE, "Mars": RED, "Jupiter": ORANGE, "Saturn": "#b8a13c",
           "Uranus": "#3aa6a6", "Neptune": "#3552c4", "Pluto": "#8a5a44"}
# What Newton's point masses, solved exactly, are off DE421 after ten years [au]: relativity, the Moon, the asteroids.
newton_itself = {"EarthMoon": 3.7e-6, "Jupiter": 4.8e-7}
rows, tracks = read("solar_system_errors.csv"), read("solar_system_orbits.csv")


def tracks_of(body):
    own = [row for row in tracks if row["body"] == body]
    return [row["x_au"] for row in own], [row["y_au"] for row in own]


def orbits(axes):
    inset = axes.inset_axes((0.03, 0.64, 0.3, 0.3))
    for body, colour in colours.items():
        inner = body in ("Mercury", "Venus", "EarthMoon", "Mars")
        x, y = tracks_of(body)
        where = inset if inner else axes
        where.plot(x, y, color=colour, linewidth=0.9 if inner else 1.3)
        where.plot(x[0], y[0], "o", color=colour, markersize=3 if inner else 5)
        if not inner:
            axes.annotate(body, (x[0], y[0]), xytext=(7, -9 if body == "Jupiter" else 3),
                          textcoords="offset points", color=colour, fontsize=10)
    axes.plot(0, 0, "*", color="#e8b400", markersize=9)
    inset.plot(0, 0, "*", color="#e8b400", markersize=7)
    inset.set(xticks=[], yticks=[], aspect="equal")
    inset.set_frame_on(False)
    inset.grid(False)
    inset.set_title("Mercury to Mars", fontsize=9, pad=0)
    axes.set(xlabel="x [au]", ylabel="y [au]", aspect="equal", xlim=(-44, 44), ylim=(-40, 48), title=f"{max(row['t_year'] for row in rows):g} years from J2000")


def work(axes, body, legend):
    years = max(row["t_year"] for row in rows if row["scheme"] == "midpoint")
    for scheme, (colour, marker) in schemes.items():
        own = [r for r in rows if r["scheme"] == scheme and r["body"] == body and r["t_year"] == years]
        best = {}  # the longer run to 49 years passes here too: one point a step size
        for row in own:
            best.setdefault(row["dt_day"], row)
        points = sorted((max(r["cpu_s"], 1e-4), r["error_au"]) for r in best.values())
        if points:
            axes.loglog(*zip(*points), marker + "-", color=colour, label=scheme, markersize=6)
            if len(points) == 1 and scheme == "backward_euler":
                axes.annotate("with Δt 4 times as long\nMercury falls into the Sun", points[0], xytext=(6, -10), color=colour,
                              textcoords="offset points", ha="right", va="top", fontsize=8.5)
    if years == 10:
        axes.axhline(newton_itself[body], color="black", linestyle="--", linewidth=1)
        axes.set_ylim(bottom=newton_itself[body] / 8)
        axes.annotate("Newton's gravity itself", (0.02, newton_itself[body]), xycoords=("axes fraction", "data"), xytext=(0, -14),
                      textcoords="offset points", fontsize=9)
    axes.set(xlabel="CPU time [s]", ylabel="distance from DE421 [au]", title=f"{body} after {years:g} years")
    if legend:
        axes.legend(loc="upper right", fontsize=8.5)


def growth(axes):
    finest = max(rows, key=lambda row: row["t_year"])["dt_day"]
    for body, colour in colours.items():
        own = [r for r in rows if r["scheme"] == "velocity_verlet" and r["dt_day"] == finest and r["body"] == body]
        points = sorted({(r["t_year"], r["error_au"]) for r in own})
        axes.loglog(*zip(*points), "o-", color=colour, markersize=4)
        axes.annotate(body, points[-1], xytext=(6, -8 if body == "Saturn" else -3), textcoords="offset points", color=colour, fontsize=10)
    axes.set(xlabel="years from J2000", ylabel="distance from DE421 [au]", xlim=(0.9, 120),
             title=f"velocity Verlet, Δt = {finest:.3f} days")


figure, (first, second, third, fourth) = plt.subplots(1, 4, figsize=(22, 5.2), layout="constrained")
orbits(first)
work(second, "Jupiter", True)
work(third, "EarthMoon", False)
growth(fourth)
save(figure, "solar_system.png")

if len(sys.argv) > 2:
    figure, (first, second) = plt.subplots(1, 2, figsize=(10, 4.6), layout="constrained")
    orbits(first)
    work(second, "Jupiter", True)
    figure.savefig(sys.argv[2], dpi=100)
    print(sys.argv[2])
