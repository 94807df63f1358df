"""The cloth on the sphere at three moments, its energies, what the sphere carries: drape*.csv and .xyz to drape.png."""
import numpy
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from style import BLUE, GREEN, RED, frames, plt, read, save

rows, moments = read("drape.csv"), list(frames("drape.xyz"))
cloth = numpy.array([[row["a"], row["b"], row["c"]] for row in read("drape_triangles.csv")], dtype=int)
centre, radius = numpy.array([0.5, 0.5, -0.34]), 0.288
light = numpy.array([-0.35, -0.75, 0.65])
light /= numpy.linalg.norm(light)

u, w = numpy.meshgrid(numpy.linspace(0, 2 * numpy.pi, 97), numpy.linspace(0, numpy.pi, 49), indexing="ij")
ball = centre + radius * numpy.stack((numpy.cos(u) * numpy.sin(w), numpy.sin(u) * numpy.sin(w), numpy.cos(w)), axis=-1)
quads = [ball[i, j] for i, j in ((slice(None, -1), slice(None, -1)), (slice(1, None), slice(None, -1)), (slice(1, None), slice(1, None)),
                                 (slice(None, -1), slice(1, None)))]
ball = numpy.stack(quads, axis=2).reshape(-1, 4, 3)


def shaded(faces, colour, both_sides):
    normal = numpy.cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0])
    normal = normal / numpy.maximum(numpy.linalg.norm(normal, axis=1, keepdims=True), 1e-30)
    bright = normal @ light
    bright = 0.35 + 0.65 * (numpy.abs(bright) if both_sides else numpy.maximum(bright, 0))
    return numpy.clip(numpy.outer(bright, colour), 0, 1)


figure = plt.figure(figsize=(20, 5.6))
shown = [moments[round((len(moments) - 1) * share)] for share in (1 / 6, 1 / 3, 1)]
for k, (time, columns) in enumerate(shown):
    axes = figure.add_axes((0.205 * k, 0, 0.205, 0.95), projection="3d", computed_zorder=False)
    faces = columns["pos"][cloth]
    outward = ball.mean(axis=1) - centre
    normal = numpy.cross(ball[:, 1] - ball[:, 0], ball[:, 2] - ball[:, 0])
    turned = numpy.where((numpy.sum(normal * outward, axis=1) < 0)[:, None, None], ball[:, ::-1], ball)
    four = numpy.concatenate((faces, faces[:, 2:]), axis=1)
    polygons = numpy.concatenate((turned, four))
    colours = numpy.concatenate((shaded(turned, (0.75, 0.72, 0.68), False), shaded(faces, (0.25, 0.5, 0.85), True)))
    axes.add_collection3d(Poly3DCollection(polygons, facecolors=colours, edgecolors=colours, linewidths=0.2))
    axes.set(xlim=(0, 1), ylim=(0, 1), zlim=(-0.68, 0.04))
    axes.set_box_aspect((1, 1, 0.72), zoom=1.4)
    axes.set_axis_off()
    axes.view_init(elev=16, azim=-62)
    figure.text(0.205 * k + 0.1, 0.92, f"t = {time:.2f} s", ha="center", fontsize=13)

t = [row["t_s"] for row in rows]
axes = figure.add_axes((0.66, 0.13, 0.15, 0.74))
axes.plot(t, [row["kinetic_J"] for row in rows], color=RED, label="kinetic")
axes.plot(t, [row["height_J"] for row in rows], color=GREEN, label="of its height")
axes.set(xlabel="t [s]", ylabel="[J]", title="energies")
axes.legend(fontsize=9)
axes = figure.add_axes((0.85, 0.13, 0.15, 0.74))
axes.plot(t, [row["carried_N"] for row in rows], color=BLUE, label="the sphere carries")
axes.axhline(rows[0]["weight_N"], color="black", linestyle="--", linewidth=1, label="the cloth weighs")
axes.set(xlabel="t [s]", ylabel="[N]", title="force on the sphere", ylim=(0, None))
axes.legend(fontsize=9)
save(figure, "drape.png")
