"""gray_scott.py <petsc program> <sundials program> <mpiexec> <its flag>: two examples, two libraries of vectors, one field."""
import csv
import pathlib
import subprocess
import sys
import tempfile

petsc, sundials, mpiexec, flag = sys.argv[1:]
n, t1, rtol = "24", "60", "1e-6"


def field(ranks, program, *arguments):
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run([mpiexec, flag, str(ranks), program, *arguments], cwd=folder, capture_output=True, text=True)
        print(done.stdout, done.stderr)
        if done.returncode != 0 or "success" not in done.stdout:
            sys.exit(f"{program} on {ranks} ranks: exit status {done.returncode}")
        with open(pathlib.Path(folder) / "gray_scott.csv") as rows:
            return [float(x) for row in csv.reader(rows) for x in row]


def apart(a, b):
    return max(abs(x - y) for x, y in zip(a, b, strict=True))


by_petsc = field(2, petsc, "-n", n, "-t1", t1, "-rtol", rtol)
alone = field(1, sundials, n, t1, rtol)
by_three = field(3, sundials, n, t1, rtol)
print(f"largest {max(by_petsc):.4f}; PETSc and SUNDIALS apart by {apart(by_petsc, alone):.1e}, 1 and 3 ranks by {apart(alone, by_three):.1e}")
if len(by_petsc) != int(n) ** 2 or not 0.1 < max(by_petsc) < 1:
    sys.exit("this is no field of spots")
if apart(by_petsc, alone) > 1e-5 or apart(alone, by_three) > 1e-5:  # printed to five digits
    sys.exit("the fields differ")
