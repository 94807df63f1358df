/// @file
/// Contacts between bodies, with friction that remembers.
///
///     Particles<double, 3, Spin> grains{positions};
///     grains.set_mass(m).set_radius(R);
///     auto force = Gravity{Eigen::Vector3d{0, 0, -9.81}} + Contact{Hooke{.stiffness = 1e5, .restitution = 0.9, .friction = 0.5}};
///     PhiStepper stepper{grains, force, symplectic_euler};
///
/// The laws are in contact_law.hpp, the force in contact_kernel.hpp, what is remembered in contact_memory.hpp. Without Spin
/// there are no torques, and no rolling friction. The force depends on the velocities. A scheme that evaluates it once a
/// step passes over the bodies once: symplectic_euler, v⁺ = v + Δt M⁻¹Ψ(t, r, v), r⁺ = r + Δt v⁺, whose v is the velocity
/// half a step before r, and which is then what LAMMPS does with `fix nve/sphere`: velocity Verlet, its dashpots seeing the
/// velocity of half a step before.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "phistep/core/simd.hpp"
#include "phistep/core/simd_math.hpp"
#include "phistep/core/structure.hpp"
#include "phistep/core/version.hpp"
#include "phistep/force/contact_kernel.hpp"
#include "phistep/force/contact_law.hpp"
#include "phistep/force/contact_memory.hpp"
#include "phistep/force/contact_pairs.hpp"
#include "phistep/force/contact_search.hpp"
#include "phistep/force/sum.hpp"

namespace phistep::inline PHISTEP_ABI {

/// What contacts did, for those who count.
struct ContactStatistics {
  std::int64_t evaluations = 0;  ///< passes over the pairs
  std::int64_t rebuilds = 0;     ///< times the pairs were found anew
  std::int64_t pairs = 0;        ///< tested at the last evaluation
  std::int64_t touching = 0;     ///< of them, in contact
};

/// @tparam Law     Hooke, Hertz, GranHooke, or a type like them
/// @tparam Scalar  the state's
template <class Law, class Scalar = double>
class Contact : public ForceTerm {
 public:
  using Pairs = ContactPairs<Scalar>;
  using Springs = SpringTable<Scalar>;
  using Memory = ContactMemory<Scalar, Pairs>;
  // Through its memory the force depends on the time since the springs were known.
  static constexpr bool uses_velocity = true, uses_time = true;

  /// @param skin  [length] pairs are kept as long as no body has moved by half of it; 0: a fraction of the radii
  explicit Contact(Materials<Law> materials, double skin = 0) : materials_{std::move(materials)}, skin_{skin} {
    if (!(skin >= 0) || !std::isfinite(skin)) throw std::invalid_argument("phistep: a skin must be finite and >= 0");
  }
  explicit Contact(const Law& law, double skin = 0) : Contact{Materials<Law>{law}, skin} {}

  void begin(auto t, auto dt, const auto& y, Memory& memory) const {
    check_view(y);
    memory.begin(t, dt);
  }
  void add(auto t, const auto& y, const Memory& memory, auto& out) const {
    const auto springs = evaluate(t, y, memory);
    memory.remember(t, springs);
    give(y, out, *memory.places);
  }
  void commit(auto t, const auto& y, Memory& memory) const {
    if (memory.accept_single()) return;
    memory.remember(t, evaluate(t, y, memory));
    memory.accept_last();
  }
  /// Of the springs, normal and tangential and of rolling [energy].
  [[nodiscard]] Scalar energy(auto t, const auto& y, const Memory& memory) const {
    Memory copy = memory;
    const auto springs = evaluate(t, y, copy);
    return sum_of_energies(*copy.places, *springs);
  }

  /// f(i, j) for every pair that may touch before pair_changes() changes, by the user's indices.
  void for_each_pair(const Memory& memory, auto&& f) const {
    if (memory.places == nullptr) return;
    const Pairs& pairs = *memory.places;
    for (std::size_t p = 0; p < pairs.places(); ++p)
      f(Eigen::Index{pairs.bodies.particle[static_cast<std::size_t>(pairs.first[p])]},
        Eigen::Index{pairs.bodies.particle[static_cast<std::size_t>(pairs.second[p])]});
  }
  [[nodiscard]] std::int64_t pair_changes() const { return statistics_.rebuilds; }

  [[nodiscard]] const ContactStatistics& statistics() const { return statistics_; }

 private:
  static constexpr int width = native_width<Scalar>;
  /// Users' orders may be random: what comes so many bodies later is fetched in time.
  static constexpr std::size_t ahead = 16;
  static void prefetch([[maybe_unused]] const void* p) {
#if defined(__GNUC__)
    __builtin_prefetch(p);
#endif
  }
  using P = Pack<Scalar, width>;

  template <class View>
  static void check_view(const View&) {
    static_assert(
        requires(const View& y) { y.body, y.v; }, "phistep: Contact needs Particles: bodies with radii");
    static_assert(std::is_same_v<typename std::remove_cvref_t<decltype(std::declval<View>().r)>::Scalar, Scalar>,
                  "phistep: Contact<Law, Scalar> must be of the state's number type: Contact<Hooke, float>{…}");
  }

  /// On a slot: in one cache line (where they are double).
  struct alignas(8 * sizeof(Scalar)) Sum {
    Scalar force[4], twist[4];
  };

  /// The bodies in slots: three structs of four numbers each.
  struct Workspace {
    std::vector<Scalar> position;    ///< x, y, z, R
    std::vector<Scalar> velocity;    ///< v, 1/R
    std::vector<Scalar> surface;     ///< R ω, 1/m
    std::vector<Sum> sum;            ///< of each slot
    std::vector<Scalar> torque;      ///< of rolling, 4 a slot
    std::vector<std::int32_t> from;  ///< of each contact, its place in the table before
    ContactSearch<Scalar, 2> plane;
    ContactSearch<Scalar, 3> space;
    Workspace() = default;
    Workspace(const Workspace&) {}  // holds nothing from call to call
    Workspace(Workspace&&) noexcept = default;
    Workspace& operator=(const Workspace&) { return *this; }
    Workspace& operator=(Workspace&&) noexcept = default;
    ~Workspace() = default;
  };

  /// Springs at (t, y); forces and torques lie in the workspace.
  template <class View>
  std::shared_ptr<Springs> evaluate(Scalar t, const View& y, const Memory& memory) const {
    constexpr bool spins = requires { y.omega; };
    check_view(y);
    prepare(y, memory);
    const Pairs& pairs = *memory.places;
    std::shared_ptr<Springs> springs = tables_.take();
    ++statistics_.evaluations;
    find_touching(pairs, *memory.springs, *springs, rolls<spins>());
    work_.sum.assign(pairs.bodies.size(), Sum{});
    if (rolls<spins>()) work_.torque.assign(4 * pairs.bodies.size(), Scalar{0});
    if (materials_.types() == 0) {
      const ContactNumbers<P> numbers = broadcast_numbers<P>(materials_(0, 0));
      compute<spins>(pairs, *memory.springs, *springs, memory.elapsed(t), [&](const auto&...) { return numbers; });
    } else {
      compute<spins>(pairs, *memory.springs, *springs, memory.elapsed(t),
                     [&](const std::int32_t* i, const std::int32_t* j) { return lookup(pairs, i, j); });
    }
    springs->close();
    return springs;
  }

  template <bool spins>
  [[nodiscard]] bool rolls() const {
    return spins && materials_.rolls();
  }

  /// Fills the slots, and finds the pairs anew where they don't serve.
  template <class View>
  void prepare(const View& y, const Memory& memory) const {
    const auto& body = y.body;
    bool serves = memory.places != nullptr;
    if (serves && memory.body != static_cast<const void*>(&body)) {
      serves = memory.places->bodies.are(body) && same_box(*memory.places, body.box);
      if (serves) memory.body = &body;
    }
    if (serves && memory.places->bodies.size() == static_cast<std::size_t>(y.r.cols()))
      serves = gather(y, *memory.places);
    else serves = false;
    if (serves) return;
    find_pairs(y, memory);
    static_cast<void>(gather(y, *memory.places));
  }

  template <class View>
  void find_pairs(const View& y, const Memory& memory) const {
    const auto& body = y.body;
    check_bodies(body, y.r.cols());
    for (Eigen::Index i = 0; i < y.r.cols(); ++i) materials_.check_type(body.type_of(i), i);
    ++statistics_.rebuilds;
    auto pairs = pools_.take();
    Scalar skin = static_cast<Scalar>(skin_);
    if (skin == Scalar{0} && y.r.cols() > 0) skin = Scalar{0.25} * body.radius.mean();
    constexpr int dim = std::remove_cvref_t<decltype(y.r)>::RowsAtCompileTime;
    if constexpr (dim == 2) work_.plane.find(y.r, body, skin, *pairs);
    else work_.space.find(y.r, body, skin, *pairs);
    auto springs = tables_.take();
    if (memory.places) {
      const bool same_bodies = memory.body == static_cast<const void*>(&body);
      carry_springs(*memory.places, *memory.springs, *pairs, *springs, same_bodies);
    } else {
      springs->resize(0, materials_.rolls());
      springs->close();
    }
    memory.places = std::move(pairs);
    memory.springs = std::move(springs);
    memory.body = &body;
  }

  [[nodiscard]] static bool same_box(const Pairs& pairs, const auto& box) {
    for (std::size_t a = 0; a < box.is_periodic.size(); ++a) {
      const auto axis = static_cast<Eigen::Index>(a);
      const Scalar period = box.is_periodic[a] ? box.upper[axis] - box.lower[axis] : Scalar{0};
      if (pairs.period[a] != period) return false;
    }
    return true;
  }

  /// False: a body has moved by half the skin since the pairs were found.
  template <class View>
  [[nodiscard]] bool gather(const View& y, const Pairs& pairs) const {
    constexpr int dim = std::remove_cvref_t<decltype(y.r)>::RowsAtCompileTime;
    const std::size_t n = pairs.bodies.size();
    work_.position.resize(4 * n), work_.velocity.resize(4 * n), work_.surface.resize(4 * n);
    Scalar largest = 0;
    for (std::size_t s = 0; s < n; ++s) {
      const Eigen::Index i = pairs.bodies.particle[s];
      if (s + ahead < n) {
        const Eigen::Index next = pairs.bodies.particle[s + ahead];
        prefetch(y.r.data() + dim * next);
        prefetch(y.v.data() + dim * next);
        if constexpr (requires { y.omega; }) prefetch(y.omega.data() + y.omega.rows() * next);
      }
      const Scalar radius = pairs.bodies.radius[s];
      Scalar* const x = &work_.position[4 * s];
      Scalar* const v = &work_.velocity[4 * s];
      Scalar* const u = &work_.surface[4 * s];
      const Scalar* const from = &pairs.built_at[4 * s];
      x[2] = v[2] = u[0] = u[1] = u[2] = 0;
      Scalar moved = 0;
      for (int a = 0; a < dim; ++a) {
        x[a] = y.r(a, i);
        v[a] = y.v(a, i);
        moved += (x[a] - from[a]) * (x[a] - from[a]);
      }
      largest = largest < moved ? moved : largest;  // a NaN is near to nothing: its force says so
      if constexpr (requires { y.omega; }) {
        if constexpr (dim == 3)
          for (int a = 0; a < 3; ++a) u[a] = radius * y.omega(a, i);
        else u[2] = radius * y.omega(0, i);
      }
      x[3] = radius;
      v[3] = pairs.bodies.inverse_radius[s];
      u[3] = pairs.bodies.inverse_mass[s];
    }
    return 4 * largest <= pairs.skin * pairs.skin;
  }

  [[gnu::flatten]] void find_touching(const Pairs& pairs, const Springs& before, Springs& springs,
                                      bool with_roll) const {
    const std::size_t count = pairs.places();
    auto& contact = springs.place;
    auto& from = work_.from;
    contact.resize(count + width);
    from.resize(count + width);
    std::size_t found = 0, old = 0;
    const std::size_t known = before.size();
    const Triple<P> period{pairs.period[0], pairs.period[1], pairs.period[2]};
    const Triple<P> inverse = inverse_of(pairs);
    for (std::size_t p = 0; p < count; p += width) {
      const auto a = gather4<P>(work_.position.data(), &pairs.first[p]);
      const auto b = gather4<P>(work_.position.data(), &pairs.second[p]);
      const Triple<P> d = difference(a, b, period, inverse);
      const P reach = a.w + b.w;
      unsigned touching = (dot(d, d) < reach * reach).bits();
      if (count - p < width) touching &= (1u << (count - p)) - 1u;
      while (touching != 0) {
        const auto place = static_cast<std::int32_t>(p) + std::countr_zero(touching);
        touching &= touching - 1;
        while (old < known && before.place[old] < place) ++old;
        contact[found] = place;
        from[found] = static_cast<std::int32_t>(old < known && before.place[old] == place ? old : known);
        ++found;
      }
    }
    springs.resize(found, with_roll);
    from.resize(found + width, static_cast<std::int32_t>(known));
    std::fill(from.begin() + static_cast<std::ptrdiff_t>(found), from.end(), static_cast<std::int32_t>(known));
    statistics_.pairs = static_cast<std::int64_t>(count);
    statistics_.touching = static_cast<std::int64_t>(found);
  }

  [[nodiscard]] static Triple<P> inverse_of(const Pairs& pairs) {
    const auto inverse = [](Scalar period) { return period > 0 ? Scalar{1} / period : Scalar{0}; };
    return {inverse(pairs.period[0]), inverse(pairs.period[1]), inverse(pairs.period[2])};
  }
  [[nodiscard]] static Triple<P> difference(const FourPacks<P>& a, const FourPacks<P>& b, const Triple<P>& period,
                                            const Triple<P>& inverse) {
    return {nearest_image(a.x - b.x, period.x, inverse.x), nearest_image(a.y - b.y, period.y, inverse.y),
            nearest_image(a.z - b.z, period.z, inverse.z)};
  }

  template <bool spins>
  void compute(const Pairs& pairs, const Springs& before, Springs& after, Scalar elapsed, auto&& numbers) const {
    if (rolls<spins>()) compute_contacts<spins, spins>(pairs, before, after, elapsed, numbers);
    else compute_contacts<spins, false>(pairs, before, after, elapsed, numbers);
  }

  template <bool spins, bool rolls>
  [[gnu::flatten]] void compute_contacts(const Pairs& pairs, const Springs& before, Springs& after, Scalar elapsed,
                                         auto& numbers) const {
    const Triple<P> period{pairs.period[0], pairs.period[1], pairs.period[2]};
    const Triple<P> inverse = inverse_of(pairs);
    const std::size_t count = after.size();
    for (std::size_t c = 0; c < count; c += width) {
      const std::size_t lanes = std::min<std::size_t>(width, count - c);
      std::int32_t place[width], i[width], j[width];
      for (std::size_t l = 0; l < width; ++l) {
        place[l] = after.place[c + std::min(l, lanes - 1)];
        i[l] = pairs.first[static_cast<std::size_t>(place[l])];
        j[l] = pairs.second[static_cast<std::size_t>(place[l])];
      }
      const auto ri = gather4<P>(work_.position.data(), i), rj = gather4<P>(work_.position.data(), j);
      const auto vi = gather4<P>(work_.velocity.data(), i), vj = gather4<P>(work_.velocity.data(), j);
      const auto ui = gather4<P>(work_.surface.data(), i), uj = gather4<P>(work_.surface.data(), j);
      const Triple<P> d = difference(ri, rj, period, inverse);
      const P square = dot(d, d), reach = ri.w + rj.w;
      const P distance = sqrt(square);
      // Two centres in one point have no direction: no force, the symmetric choice.
      const P one_over = select(square > P(0), P(1) / distance, P(0));
      ContactPoint<P> at{one_over * d,
                         reach - distance,
                         has_full_arms<Law> ? P(1) : distance / reach,
                         {vi.x - vj.x, vi.y - vj.y, vi.z - vj.z},
                         {ui.x + uj.x, ui.y + uj.y, ui.z + uj.z},
                         ui.w + uj.w,
                         vi.w + vj.w};
      if constexpr (rolls)
        at.turning = {vi.w * ui.x - vj.w * uj.x, vi.w * ui.y - vj.w * uj.y, vi.w * ui.z - vj.w * uj.z};
      ContactSprings<P> springs{load(before.slip, &work_.from[c]), {}};
      if constexpr (rolls) springs.roll = load(before.roll, &work_.from[c]);
      const ContactForce<P> f = contact_force<spins, rolls, Law>(
          numbers(static_cast<const std::int32_t*>(i), static_cast<const std::int32_t*>(j)), at, P(elapsed), springs);
      store(springs.slip, after.slip, c);
      if constexpr (rolls) store(springs.roll, after.roll, c);
      for (std::size_t l = 0; l < lanes; ++l) {
        const int k = static_cast<int>(l);
        Sum& a = work_.sum[static_cast<std::size_t>(i[l])];
        Sum& b = work_.sum[static_cast<std::size_t>(j[l])];
        const Scalar force[3] = {f.force.x[k], f.force.y[k], f.force.z[k]};
        for (int e = 0; e < 3; ++e) a.force[e] += force[e], b.force[e] -= force[e];
        if constexpr (spins) {
          const Scalar twist[3] = {f.twist.x[k], f.twist.y[k], f.twist.z[k]};
          for (int e = 0; e < 3; ++e) a.twist[e] += twist[e], b.twist[e] += twist[e];
        }
        if constexpr (rolls) {
          Scalar* const p = &work_.torque[4 * static_cast<std::size_t>(i[l])];
          Scalar* const q = &work_.torque[4 * static_cast<std::size_t>(j[l])];
          const Scalar tx = f.torque.x[k], ty = f.torque.y[k], tz = f.torque.z[k];
          p[0] += tx, p[1] += ty, p[2] += tz;
          q[0] -= tx, q[1] -= ty, q[2] -= tz;
        }
      }
    }
  }

  using Lengths = typename Springs::Lengths;
  [[nodiscard]] static Triple<P> load(const Lengths& table, const std::int32_t* from) {
    // Mostly the same contacts touch as before, and stand in the same order.
    bool in_line = true;
    for (int l = 1; l < width; ++l) in_line &= from[l] == from[0] + l;
    const auto at = [&](const std::vector<Scalar>& x) {
      return in_line ? P::load(&x[static_cast<std::size_t>(from[0])]) : P::gather(x.data(), from);
    };
    return {at(table.x[0]), at(table.x[1]), at(table.x[2])};
  }
  /// May write behind the last contact, where others follow or none.
  static void store(const Triple<P>& lengths, Lengths& table, std::size_t at) {
    lengths.x.store(&table.x[0][at]);
    lengths.y.store(&table.x[1][at]);
    lengths.z.store(&table.x[2][at]);
  }

  [[nodiscard]] ContactNumbers<P> lookup(const Pairs& pairs, const std::int32_t* i, const std::int32_t* j) const {
    const ContactNumbers<double>* of[width];
    for (int l = 0; l < width; ++l)
      of[l] = &materials_(pairs.bodies.type[static_cast<std::size_t>(i[l])],
                          pairs.bodies.type[static_cast<std::size_t>(j[l])]);
    return lane_numbers<P>(of);
  }

  /// From slots to the user's order.
  template <class View>
  void give(const View& y, auto& out, const Pairs& pairs) const {
    constexpr int dim = std::remove_cvref_t<decltype(y.r)>::RowsAtCompileTime;
    constexpr bool spins = requires { y.omega; };
    const bool turned = rolls<spins>();
    const std::size_t n = pairs.bodies.size();
    for (std::size_t i = 0; i < n; ++i) {
      const auto s = static_cast<std::size_t>(pairs.bodies.slot[i]);
      const auto column = static_cast<Eigen::Index>(i);
      if (i + ahead < n) prefetch(&work_.sum[static_cast<std::size_t>(pairs.bodies.slot[i + ahead])]);
      const Sum& of = work_.sum[s];
      // x − x: 0, or NaN for a body whose place is not a number, which touches nothing
      for (int a = 0; a < dim; ++a) out.force(a, column) += of.force[a] + (y.r(a, column) - y.r(a, column));
      if constexpr (spins) {
        const Scalar radius = y.body.radius[column];
        const auto torque = [&](int a) {
          return radius * of.twist[a] + (turned ? work_.torque[4 * s + static_cast<std::size_t>(a)] : Scalar{0});
        };
        if constexpr (dim == 3)
          for (int a = 0; a < 3; ++a) out.torque(a, column) += torque(a);
        else out.torque(0, column) += torque(2);
      }
    }
  }

  [[nodiscard]] Scalar sum_of_energies(const Pairs& pairs, const Springs& springs) const {
    Scalar sum{0};
    for (std::size_t c = 0; c < springs.size(); ++c) {
      const auto p = static_cast<std::size_t>(springs.place[c]);
      const auto i = static_cast<std::size_t>(pairs.first[p]), j = static_cast<std::size_t>(pairs.second[p]);
      Scalar square{0};
      for (std::size_t a = 0; a < 3; ++a) {
        const Scalar d = nearest_image(work_.position[4 * i + a] - work_.position[4 * j + a], pairs.period[a],
                                       pairs.period[a] > 0 ? Scalar{1} / pairs.period[a] : Scalar{0});
        square += d * d;
      }
      const Scalar overlap = pairs.bodies.radius[i] + pairs.bodies.radius[j] - std::sqrt(square);
      const Scalar rho = Scalar{1} / pairs.bodies.radius[i] + Scalar{1} / pairs.bodies.radius[j];
      const auto numbers = broadcast_numbers<Scalar>(materials_(pairs.bodies.type[i], pairs.bodies.type[j]));
      Scalar slip[3], roll[3] = {0, 0, 0};
      for (std::size_t a = 0; a < 3; ++a) {
        slip[a] = springs.slip.x[a][c];
        if (springs.rolls()) roll[a] = springs.roll.x[a][c];
      }
      sum += stored_energy<Law, Scalar>(numbers, overlap, rho, slip, roll);
    }
    return sum;
  }

  Materials<Law> materials_;
  double skin_;
  mutable Workspace work_;
  mutable Recycled<Springs> tables_;
  mutable Recycled<Pairs> pools_;
  mutable ContactStatistics statistics_;
};
template <class Law>
Contact(const Law&, double = 0) -> Contact<Law>;
template <class Law>
Contact(Materials<Law>, double = 0) -> Contact<Law>;

}  // namespace phistep::inline PHISTEP_ABI
