/// @file
/// The passes over bodies and pairs that a force of contacts is made of:
///
///   gather    bodies into slots in cache order; the pairs are found anew where one moved too far
///   touch     which pairs touch: positions only
///   compute   the law (contact_kernel.hpp) for those, a pack at a time, and its sum on each slot
///   give      from the slots to the user's order
///
/// Each pair is computed once. A body's forces add up in the order of its pairs, whatever the number of threads.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

#include "phistep/contacts/contact_kernel.hpp"
#include "phistep/contacts/contact_law.hpp"
#include "phistep/contacts/contact_memory.hpp"
#include "phistep/contacts/contact_pairs.hpp"
#include "phistep/contacts/contact_search.hpp"
#include "phistep/core/scratch.hpp"
#include "phistep/core/structure.hpp"
#include "phistep/core/version.hpp"
#include "phistep/simd/pack.hpp"
#include "phistep/simd/pack_math.hpp"

#ifdef _OPENMP
#include <omp.h>
#endif

namespace phistep::inline PHISTEP_ABI {

/// What contacts did, for those who count.
struct ContactStatistics {
  std::int64_t evaluations = 0;  ///< passes over the pairs
  std::int64_t rebuilds = 0;     ///< times the pairs were found anew
  std::int64_t pairs = 0;        ///< tested at the last evaluation
  std::int64_t touching = 0;     ///< of them, in contact
};

template <class Law, class Scalar>
class ContactPasses {
 public:
  using Pairs = ContactPairs<Scalar>;
  using Springs = SpringTable<Scalar>;
  using Memory = ContactMemory<Scalar, Pairs>;

  /// @param skin  [length], 0: a fraction of the radii
  ContactPasses(Materials<Law> materials, double skin) : materials_{std::move(materials)}, skin_{skin} {}
  [[nodiscard]] const ContactStatistics& statistics() const { return statistics_; }
  [[nodiscard]] const Materials<Law>& materials() const { return materials_; }

  /// Springs at (t, y); forces and torques lie in the workspace.
  template <class View>
  std::shared_ptr<Springs> evaluate(Scalar t, const View& y, const Memory& memory) const {
    constexpr bool spins = requires { y.omega; };
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

  /// From slots to the user's order.
  template <class View>
  void give(const View& y, auto& out, const Pairs& pairs) const {
    constexpr int dim = std::remove_cvref_t<decltype(y.r)>::RowsAtCompileTime;
    constexpr bool spins = requires { y.omega; };
    const bool turned = rolls<spins>();
    const std::size_t n = pairs.bodies.size();
#ifdef _OPENMP
#pragma omp parallel for schedule(static)
#endif
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

  /// Σ of the energies stored in the springs.
  [[nodiscard]] Scalar energy(const Pairs& pairs, const Springs& springs) const {
    Scalar sum{0};
    for (std::size_t c = 0; c < springs.size(); ++c) {
      const auto p = static_cast<std::size_t>(springs.place[c]);
      const Meeting meeting = meet(pairs, p);
      Scalar slip[3], roll[3] = {0, 0, 0};
      for (std::size_t a = 0; a < 3; ++a) {
        slip[a] = springs.slip.x[a][c];
        if (springs.rolls()) roll[a] = springs.roll.x[a][c];
      }
      sum += stored_energy<Law, Scalar>(meeting.numbers, meeting.overlap, meeting.rho, slip, roll);
    }
    return sum;
  }

  /// f(i, j, n, K, C) for all pairs, with the users' indices and n from j to i; K and C are 0 where they don't touch.
  void for_each_tangent(const Pairs& pairs, const Springs& springs, Scalar elapsed, auto&& f) const {
    std::size_t c = 0;
    for (std::size_t p = 0; p < pairs.places(); ++p) {
      const Meeting at = meet(pairs, p);
      const auto i = static_cast<std::size_t>(pairs.first[p]), j = static_cast<std::size_t>(pairs.second[p]);
      PairTangent<Scalar> K, C;
      if (c < springs.size() && static_cast<std::size_t>(springs.place[c]) == p) {
        Triple<Scalar> v{}, slip{springs.slip.x[0][c], springs.slip.x[1][c], springs.slip.x[2][c]};
        for (auto [a, component] : {std::pair{0u, &v.x}, std::pair{1u, &v.y}, std::pair{2u, &v.z}})
          *component = work_.velocity[4 * i + a] - work_.velocity[4 * j + a];
        contact_tangent<Law>(at.numbers, {at.n[0], at.n[1], at.n[2]}, at.overlap, at.distance, v, slip,
                             work_.surface[4 * i + 3] + work_.surface[4 * j + 3], at.rho, elapsed, K, C);
        ++c;
      }
      f(pairs.bodies.particle[i], pairs.bodies.particle[j], at.n, K, C);
    }
  }

 private:
  /// Two bodies of the last evaluation.
  struct Meeting {
    Scalar n[3], distance, overlap, rho;
    ContactNumbers<Scalar> numbers;
  };
  [[nodiscard]] Meeting meet(const Pairs& pairs, std::size_t p) const {
    const auto i = static_cast<std::size_t>(pairs.first[p]), j = static_cast<std::size_t>(pairs.second[p]);
    const auto& bodies = pairs.bodies;
    Meeting out{{},
                {},
                {},
                bodies.inverse_radius[i] + bodies.inverse_radius[j],
                broadcast_numbers<Scalar>(materials_(bodies.type[i], bodies.type[j]))};
    Scalar square{0};
    for (std::size_t a = 0; a < 3; ++a) {
      const Scalar period = pairs.period[a];
      out.n[a] = nearest_image(work_.position[4 * i + a] - work_.position[4 * j + a], period,
                               period > 0 ? Scalar{1} / period : Scalar{0});
      square += out.n[a] * out.n[a];
    }
    out.distance = std::sqrt(square);
    out.overlap = bodies.radius[i] + bodies.radius[j] - out.distance;
    for (Scalar& x : out.n) x *= out.distance > 0 ? Scalar{1} / out.distance : Scalar{0};
    return out;
  }

  static constexpr int width = native_width<Scalar>;
  /// Users' orders may be random: what comes so many bodies later is fetched in time.
  static constexpr std::size_t ahead = 16;
  static void prefetch([[maybe_unused]] const void* p) {
#if defined(__GNUC__)
    __builtin_prefetch(p);
#endif
  }
  using P = Pack<Scalar, width>;

  /// On a slot: in one cache line (where they are double).
  struct alignas(8 * sizeof(Scalar)) Sum {
    Scalar force[4], twist[4];
  };

  /// Of one contact.
  struct Effect {
    Scalar force[3], twist[3], torque[3];
  };

  /// The bodies in slots: three structs of four numbers each.
  struct Workspace {
    std::vector<Scalar> position;    ///< x, y, z, R
    std::vector<Scalar> velocity;    ///< v, 1/R
    std::vector<Scalar> surface;     ///< R ω, 1/m
    std::vector<Sum> sum;            ///< of each slot
    std::vector<Scalar> torque;      ///< of rolling, 4 a slot
    std::vector<std::int32_t> from;  ///< of each contact, its place in the table before
    std::vector<std::int32_t> i, j;  ///< … and its slots
    std::vector<Effect> effects;     ///< of each contact, where threads share the work
    std::vector<std::size_t> found;  ///< contacts, by each thread
    ContactSearch<Scalar, 2> plane;
    ContactSearch<Scalar, 3> space;
  };

  template <bool spins>
  [[nodiscard]] bool rolls() const {
    return spins && materials_.rolls();
  }

  /// Fills the slots, and finds the pairs anew where they don't serve.
  template <class View>
  void prepare(const View& y, const Memory& memory) const {
    const auto& body = y.body;
    bool serves = memory.places != nullptr;
    if (serves && memory.body != body.serial) {
      serves = memory.places->bodies.are(body) && same_box(*memory.places, body.box);
      if (serves) adopt(body, memory);
    }
    if (serves && memory.places->bodies.size() == static_cast<std::size_t>(y.r.cols()))
      serves = gather(y, *memory.places);
    else serves = false;
    if (serves) return;
    find_pairs(y, memory);
    static_cast<void>(gather(y, *memory.places));
  }

  /// A checkpoint's pairs are those of these bodies; its springs may be another force's.
  void adopt(const auto& body, const Memory& memory) const {
    check_types(body);
    memory.body = body.serial;
    if (memory.springs->rolls() == materials_.rolls()) return;
    auto springs = std::make_shared<Springs>(*memory.springs);
    springs->resize(springs->size(), materials_.rolls());
    springs->close();
    memory.springs = std::move(springs);
  }
  void check_types(const auto& body) const {
    for (Eigen::Index i = 0; i < body.size(); ++i) materials_.check_type(body.type_of(i), i);
  }

  template <class View>
  void find_pairs(const View& y, const Memory& memory) const {
    const auto& body = y.body;
    check_bodies(body, y.r.cols());
    check_types(body);
    ++statistics_.rebuilds;
    auto pairs = pools_.take();
    Scalar skin = static_cast<Scalar>(skin_);
    if (skin == Scalar{0} && y.r.cols() > 0) skin = static_cast<Scalar>(0.6) * body.radius.mean();
    constexpr int dim = std::remove_cvref_t<decltype(y.r)>::RowsAtCompileTime;
    if constexpr (dim == 2) work_.plane.find(y.r, body, skin, *pairs);
    else work_.space.find(y.r, body, skin, *pairs);
    auto springs = tables_.take();
    if (memory.places) {
      const bool same_bodies = memory.body == body.serial;
      carry_springs(*memory.places, *memory.springs, *pairs, *springs, materials_.rolls(), same_bodies, memory.dormant);
    } else {
      springs->resize(0, materials_.rolls());
      springs->close();
    }
    memory.places = std::move(pairs);
    memory.springs = std::move(springs);
    memory.body = body.serial;
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
#ifdef _OPENMP
#pragma omp parallel for schedule(static) reduction(max : largest)
#endif
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

  /// Threads write where their own pairs stand; then the gaps are closed.
  void find_touching(const Pairs& pairs, const Springs& before, Springs& springs, bool with_roll) const {
    const std::size_t count = pairs.places(), share = share_of(count, width);
    auto& contact = springs.place;
    auto& from = work_.from;
    contact.resize(count + width);
    for (auto* array : {&from, &work_.i, &work_.j}) array->resize(count + width);
    work_.found.assign(threads(), 0);
#ifdef _OPENMP
#pragma omp parallel for schedule(static, 1)
#endif
    for (std::size_t t = 0; t < threads(); ++t) {
      const std::size_t begin = std::min(count, t * share), end = std::min(count, begin + share);
      work_.found[t] = find_touching(pairs, before, begin, end, contact.data());
    }
    std::size_t found = work_.found[0];
    for (std::size_t t = 1; t < threads(); ++t) {
      const auto begin = static_cast<std::ptrdiff_t>(std::min(count, t * share)),
                 end = begin + static_cast<std::ptrdiff_t>(work_.found[t]);
      for (auto* array : {&contact, &from, &work_.i, &work_.j})
        std::copy(array->begin() + begin, array->begin() + end, array->begin() + static_cast<std::ptrdiff_t>(found));
      found += work_.found[t];
    }
    springs.resize(found, with_roll);
    // Whole packs: those beyond the last contact repeat its slots, and find springs that are unstretched.
    std::fill_n(from.begin() + static_cast<std::ptrdiff_t>(found), width, static_cast<std::int32_t>(before.size()));
    for (auto* array : {&work_.i, &work_.j})
      std::fill_n(array->begin() + static_cast<std::ptrdiff_t>(found), width, found > 0 ? (*array)[found - 1] : 0);
    statistics_.pairs = static_cast<std::int64_t>(count);
    statistics_.touching = static_cast<std::int64_t>(found);
  }
  [[gnu::flatten]] std::size_t find_touching(const Pairs& pairs, const Springs& before, std::size_t begin,
                                             std::size_t end, std::int32_t* contact) const {
    const auto known = static_cast<std::int32_t>(before.size());
    auto old = static_cast<std::int32_t>(
        std::lower_bound(before.place.begin(), before.place.end(), static_cast<std::int32_t>(begin)) -
        before.place.begin());
    const std::int32_t* const places = before.place.data();
    std::int32_t* const from = work_.from.data();
    std::int32_t *const i = work_.i.data(), *const j = work_.j.data();
    std::size_t found = begin;
    const Triple<P> period{pairs.period[0], pairs.period[1], pairs.period[2]};
    const Triple<P> inverse = inverse_of(pairs);
    for (std::size_t p = begin; p < end; p += width) {
      const auto a = gather4<P>(work_.position.data(), &pairs.first[p]);
      const auto b = gather4<P>(work_.position.data(), &pairs.second[p]);
      const Triple<P> d = difference(a, b, period, inverse);
      const P reach = a.w + b.w;
      unsigned touching = (dot(d, d) < reach * reach).bits();
      if (end - p < width) touching &= (1u << (end - p)) - 1u;
      while (touching != 0) {
        const auto place = static_cast<std::int32_t>(p) + std::countr_zero(touching);
        touching &= touching - 1;
        while (old < known && places[old] < place) ++old;
        contact[found] = place;
        from[found] = old < known && places[old] == place ? old : known;
        i[found] = pairs.first[static_cast<std::size_t>(place)];
        j[found] = pairs.second[static_cast<std::size_t>(place)];
        ++found;
      }
    }
    return found - begin;
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

  /// With one thread forces are added to the bodies at once. With more, each keeps its contacts' forces; then each adds up
  /// those on its own bodies, in the same order.
  template <bool spins, bool rolls>
  [[gnu::flatten]] void compute_contacts(const Pairs& pairs, const Springs& before, Springs& after, Scalar elapsed,
                                         auto& numbers) const {
    const std::size_t count = after.size();
    if (threads() == 1) {
      for (std::size_t c = 0; c < count; c += width) {
        const ContactForce<P> f = force_of<spins, rolls>(pairs, before, after, elapsed, numbers, c);
        for (std::size_t l = 0; l < width && c + l < count; ++l) {
          const Effect effect = lane<spins, rolls>(f, l);
          put<rolls>(effect, 1, static_cast<std::size_t>(work_.i[c + l]));
          put<rolls>(effect, -1, static_cast<std::size_t>(work_.j[c + l]));
        }
      }
      return;
    }
    work_.effects.resize(count);
#ifdef _OPENMP
#pragma omp parallel for schedule(static)
#endif
    for (std::size_t c = 0; c < count; c += width) {
      const ContactForce<P> f = force_of<spins, rolls>(pairs, before, after, elapsed, numbers, c);
      for (std::size_t l = 0; l < width && c + l < count; ++l) work_.effects[c + l] = lane<spins, rolls>(f, l);
    }
    const std::size_t n = pairs.bodies.size(), share = share_of(n, 1);
#ifdef _OPENMP
#pragma omp parallel for schedule(static, 1)
#endif
    for (std::size_t t = 0; t < threads(); ++t) {
      const std::size_t low = std::min(n, t * share), high = std::min(n, low + share);
      const auto place = [&](std::size_t slot) {
        return static_cast<std::size_t>(std::lower_bound(after.place.begin(), after.place.end(), pairs.row[slot]) -
                                        after.place.begin());
      };
      const std::size_t begin = place(low), end = place(high);
      for (std::size_t c = 0; c < end; ++c) {
        const auto j = static_cast<std::size_t>(work_.j[c]);
        if (c >= begin) put<rolls>(work_.effects[c], 1, static_cast<std::size_t>(work_.i[c]));
        if (j >= low && j < high) put<rolls>(work_.effects[c], -1, j);
      }
    }
  }

  template <bool spins, bool rolls>
  [[nodiscard]] ContactForce<P> force_of(const Pairs& pairs, const Springs& before, Springs& after, Scalar elapsed,
                                         auto& numbers, std::size_t c) const {
    const std::int32_t *const i = &work_.i[c], *const j = &work_.j[c];
    if (c + 3 * width <= after.size())
      for (std::size_t l = 2 * width; l < 3 * width; ++l) {
        prefetch(&work_.velocity[4 * static_cast<std::size_t>(j[l])]);
        prefetch(&work_.surface[4 * static_cast<std::size_t>(j[l])]);
        prefetch(&work_.sum[static_cast<std::size_t>(j[l])]);
      }
    const Triple<P> period{pairs.period[0], pairs.period[1], pairs.period[2]};
    const Triple<P> inverse = inverse_of(pairs);
    const auto ri = gather4<P>(work_.position.data(), i), rj = gather4<P>(work_.position.data(), j);
    const auto vi = gather4<P>(work_.velocity.data(), i), vj = gather4<P>(work_.velocity.data(), j);
    const auto ui = gather4<P>(work_.surface.data(), i), uj = gather4<P>(work_.surface.data(), j);
    const Triple<P> d = difference(ri, rj, period, inverse);
    const P distance = sqrt(dot(d, d)), reach = ri.w + rj.w;
    // Two centres in one point have no direction: no number, and so the step says it.
    ContactPoint<P> at{(P(1) / distance) * d,
                       reach - distance,
                       has_full_arms<Law> ? P(1) : distance / reach,
                       {vi.x - vj.x, vi.y - vj.y, vi.z - vj.z},
                       {ui.x + uj.x, ui.y + uj.y, ui.z + uj.z},
                       ui.w + uj.w,
                       vi.w + vj.w};
    if constexpr (rolls) at.turning = {vi.w * ui.x - vj.w * uj.x, vi.w * ui.y - vj.w * uj.y, vi.w * ui.z - vj.w * uj.z};
    ContactSprings<P> springs{load(before.slip, &work_.from[c]), {}};
    if constexpr (rolls) springs.roll = load(before.roll, &work_.from[c]);
    const ContactForce<P> f = contact_force<spins, rolls, Law>(numbers(i, j), at, P(elapsed), springs);
    store(springs.slip, after.slip, c);
    if constexpr (rolls) store(springs.roll, after.roll, c);
    return f;
  }
  template <bool spins, bool rolls>
  [[nodiscard]] static Effect lane(const ContactForce<P>& f, std::size_t l) {
    const int k = static_cast<int>(l);
    Effect out{{f.force.x[k], f.force.y[k], f.force.z[k]}, {}, {}};
    if constexpr (spins) out.twist[0] = f.twist.x[k], out.twist[1] = f.twist.y[k], out.twist[2] = f.twist.z[k];
    if constexpr (rolls) out.torque[0] = f.torque.x[k], out.torque[1] = f.torque.y[k], out.torque[2] = f.torque.z[k];
    return out;
  }
  /// On i with the sign 1, on j with −1.
  template <bool rolls>
  void put(const Effect& effect, Scalar sign, std::size_t slot) const {
    Sum& to = work_.sum[slot];
    for (std::size_t a = 0; a < 3; ++a) to.force[a] += sign * effect.force[a], to.twist[a] += effect.twist[a];
    if constexpr (rolls)
      for (std::size_t a = 0; a < 3; ++a) work_.torque[4 * slot + a] += sign * effect.torque[a];
  }

  /// Threads that passes are shared by, and how many of n are one's share: a multiple of `unit`.
  [[nodiscard]] static std::size_t threads() {
#ifdef _OPENMP
    return static_cast<std::size_t>(omp_get_max_threads());
#else
    return 1;
#endif
  }
  [[nodiscard]] static std::size_t share_of(std::size_t n, std::size_t unit) {
    const std::size_t share = (n + threads() - 1) / threads();
    return (share + unit - 1) / unit * unit;
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

  Materials<Law> materials_;
  double skin_;
  mutable Scratch<Workspace> work_;
  mutable Recycled<Springs> tables_;
  mutable Recycled<Pairs> pools_;
  mutable ContactStatistics statistics_;
};

}  // namespace phistep::inline PHISTEP_ABI
