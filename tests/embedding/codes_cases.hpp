// What the tests of the three existing codes share: their arrays as numbers, small systems, faults.
#pragma once

#include "../../examples/existing_codes/before_and_after.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <stdexcept>
#include <vector>

#include "support/catch.hpp"

namespace codes_cases {

template <class Code>
concept IsCloth = requires(const Code& code) {
  code.beads;
};
template <class Code>
concept IsAtoms = requires(const Code& code) {
  code.natoms;
};

using Numbers = std::vector<double>;

/// Bit by bit: a NaN equals itself, and 0 is not −0.
[[nodiscard]] inline bool same_bits(const Numbers& a, const Numbers& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0);
}
[[nodiscard]] inline double distance(const Numbers& a, const Numbers& b) {
  REQUIRE(a.size() == b.size());
  double most = 0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, std::abs(a[i] - b[i]));
  return most;
}

/// x and v, or u.
template <class Code>
[[nodiscard]] Numbers state_of(const Code& code) {
  Numbers all;
  if constexpr (IsCloth<Code>) {
    for (const auto& b : code.beads) all.insert(all.end(), b.x, b.x + 3), all.insert(all.end(), b.v, b.v + 3);
  } else if constexpr (IsAtoms<Code>) {
    for (int i = 0; i < code.natoms; ++i)
      all.insert(all.end(), code.x[i], code.x[i] + 3), all.insert(all.end(), code.v[i], code.v[i] + 3);
  } else {
    all.assign(code.u, code.u + code.ncells);
  }
  return all;
}
/// f, or du/dt.
template <class Code>
[[nodiscard]] Numbers forces_of(const Code& code) {
  Numbers all;
  if constexpr (IsCloth<Code>) {
    for (const auto& b : code.beads) all.insert(all.end(), b.f, b.f + 3);
  } else if constexpr (IsAtoms<Code>) {
    for (int i = 0; i < code.natoms; ++i) all.insert(all.end(), code.f[i], code.f[i] + 3);
  } else {
    all.assign(code.dudt, code.dudt + code.ncells);
  }
  return all;
}
/// One of the forces.
template <class Code>
[[nodiscard]] double& a_force(Code& code) {
  if constexpr (IsCloth<Code>) return code.beads[code.beads.size() / 2].f[1];
  else if constexpr (IsAtoms<Code>) return code.f[code.natoms / 2][1];
  else return code.dudt[code.ncells / 2];
}

/// Three of the codes' loops; the cloth has two.
struct Euler {
  static constexpr double dt = 5e-4;
  static void run(auto& cloth, int steps) { cloth.run_euler(steps, dt); }
};
struct Verlet {
  static constexpr double dt = 5e-4;
  static void run(auto& cloth, int steps) { cloth.run_verlet(steps, dt); }
};
struct Atoms {
  static constexpr double dt = 0.004;
  static void run(auto& atoms, int steps) { atoms.run(steps, dt); }
};
struct Heat {
  static constexpr double dt = 1e-4;
  static void run(auto& plate, int steps) { plate.run(steps, dt); }
};

enum class Trouble { nan, infinity, exception };
struct Struck : std::runtime_error {
  Struck() : std::runtime_error("struck") {}
};

/// From now on, the `at`-th call of the code's force routine goes wrong.
template <class Code>
void strike(Code& code, long at, Trouble trouble) {
  code.probe = [&code, trouble, left = at]() mutable {
    if (--left != 0) return;
    if (trouble == Trouble::exception) throw Struck();
    a_force(code) = trouble == Trouble::nan ? std::nan("") : HUGE_VAL;
  };
}

// ---- the codes' arrays as states ------------------------------------------------------------------------------------

/// A code's arrays as a state in place, and the force of its routine: use(state, force).
void in_place(after::Cloth& cloth, auto use) {
  using phistep::places, after::Bead;
  auto& beads = cloth.beads;
  phistep::MotionInPlace state{places(beads, &Bead::x), places(beads, &Bead::v), places(beads, &Bead::f)};
  use(state, state.force_of_r([&cloth] { cloth.compute_forces(); }));
}
void in_place(after::MolecularDynamics& atoms, auto use) {
  using phistep::places;
  phistep::MotionInPlace state{places(atoms.x, atoms.natoms), places(atoms.v, atoms.natoms),
                               places(atoms.f, atoms.natoms)};
  use(state, state.force_of_r([&atoms] { atoms.compute_forces(); }));
}
void in_place(after::HeatPlate& plate, auto use) {
  using phistep::places;
  phistep::VectorInPlace state{places(plate.u, plate.ncells), places(plate.dudt, plate.ncells)};
  use(state, state.force([&plate] { plate.compute_rates(); }));
}
/// What the mass is in M y' = Ψ.
inline auto mass_of(after::Cloth& cloth) { return phistep::mass(phistep::places(cloth.beads, &after::Bead::m)); }
inline auto mass_of(const after::MolecularDynamics& atoms) { return phistep::mass(atoms.mass); }

}  // namespace codes_cases
