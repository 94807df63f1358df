"""The cloth at four moments, its triangles coloured by height: cloth.xyz and cloth_triangles.csv to cloth.png."""
from style import frames, plt, read, save

triangles = [(int(row["a"]), int(row["b"]), int(row["c"])) for row in read("cloth_triangles.csv")]
moments = [(time, *columns["pos"].T) for time, columns in frames("cloth.xyz")]
last = len(moments) - 1
shown = [moments[round(last * share)] for share in (1 / 3, 2 / 3, 1)]
heights = [z for moment in shown for z in moment[3]]
low = [min(min(moment[axis]) for moment in shown) for axis in (1, 2, 3)]
high = [max(max(moment[axis]) for moment in shown) for axis in (1, 2, 3)]

figure = plt.figure(figsize=(15, 3.2))
figure.text(0.985, 0.5, " ")  # keeps the last axis label inside the picture
for k, (time, x, y, z) in enumerate(shown):
    axes = figure.add_axes((0.325 * k, -0.2, 0.31, 1.5), projection="3d")
    axes.plot_trisurf(x, y, z, triangles=triangles, cmap="viridis", vmin=min(heights), vmax=max(heights),
                      edgecolor="black", linewidth=0.06)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set_title(f"t = {time:.2f} s", y=0.84)
    axes.set_xlabel("x [m]", labelpad=12), axes.set_ylabel("y [m]", labelpad=12), axes.set_zlabel("z [m]" if k == 2 else "", labelpad=6)
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.set_major_locator(plt.MaxNLocator(3))
    axes.set_box_aspect([b - a + 1e-9 for a, b in zip(low, high)], zoom=0.95)
    if k < 2:
        axes.zaxis.set_ticklabels([])
    axes.view_init(elev=14, azim=-60)
save(figure, "cloth.png")
