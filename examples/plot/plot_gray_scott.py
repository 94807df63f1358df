"""The spots of examples/ranks/gray_scott_petsc.cpp or gray_scott_sundials.cpp: gray_scott.csv to gray_scott.png."""
import numpy

from style import out, plt, save

v = numpy.loadtxt(out / "gray_scott.csv", delimiter=",")
figure, axes = plt.subplots(figsize=(5.6, 4.8), layout="constrained")
axes.grid(False)
mesh = axes.imshow(v, origin="lower", extent=(0, 2.5, 0, 2.5), cmap="viridis")
axes.set(xlabel="x", ylabel="y", title="v of Gray and Scott's reaction")
figure.colorbar(mesh, ax=axes, label="v")
save(figure, "gray_scott.png")
