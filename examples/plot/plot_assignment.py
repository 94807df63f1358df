"""The three schemes of the assignment beside its closed form: assignment.csv to assignment.png."""
from style import BLUE, GREEN, RED, plt, read, save

rows = read("assignment.csv")
figure, axes = plt.subplots(figsize=(7.2, 4.6), layout="constrained")
exact = [row for row in rows if row["scheme"] == "exact"]
axes.plot([r["t_s"] for r in exact], [r["theta_K"] for r in exact], color="black", label="closed form")
for name, style in (("forward Euler", "s-"), ("trapezoidal", "o-"), ("backward Euler", "^-")):
    own = [row for row in rows if str(row["scheme"]).startswith(name)]
    colour = {"forward Euler": RED, "trapezoidal": BLUE, "backward Euler": GREEN}[name]
    axes.plot([r["t_s"] for r in own], [r["theta_K"] for r in own], style, color=colour, label=own[0]["scheme"], linewidth=1)
axes.set(xlabel="t [s]", ylabel="θ [K]", title="ρCθ' = −B cos(2t) x + ρaI")
axes.legend()
save(figure, "assignment.png")
