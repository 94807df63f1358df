/// @file
/// Short-range forces between all pairs closer than a cutoff, by any law.
///
/// f_i = Σ_j g(r²) d,  d = r_i − r_j (the images in a periodic box included),  r = |d| < r_c,  g = F/r as in pair_laws.hpp
/// ∂f_i/∂r_j = −[g I + 2 g'(r²) d dᵀ] = K_along n nᵀ + K_across (I − n nᵀ),  K_along = −(g + 2r² g'), K_across = −g
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "phistep/base/facts/structure.hpp"
#include "phistep/base/machine/loop_hints.hpp"
#include "phistep/base/machine/memory.hpp"
#include "phistep/base/numbers/arithmetic.hpp"
#include "phistep/base/numbers/dual.hpp"
#include "phistep/base/numbers/pack.hpp"
#include "phistep/base/numbers/pack_math.hpp"
#include "phistep/base/state/active_set.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/force/sum.hpp"
#include "phistep/particles/neighbors/neighbor_list.hpp"
#include "phistep/particles/neighbors/neighbors.hpp"
#include "phistep/particles/pairs/pair_laws.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// Options of the neighbour list behind a Pairs term.
struct PairOptions {
  double skin = 0;  ///< [length] listed beyond the cutoff; 0: found (neighbor_list.hpp), from 0.16 r_c on
  /// n > 0: the list is made every n steps, and misses pairs: for comparisons with codes that do so.
  std::int32_t unchecked_every = 0;
};

/// The force of a law between all pairs closer than a cutoff.
/// @tparam Law   see pair_laws.hpp
/// @tparam flat  dimensions of a state whose positions are one flat vector; 0: they are a dim × N matrix
template <class Law, int flat = 0>
class Pairs : public ForceTerm {
  template <class View>
  struct Shape {
    using Positions = std::remove_cvref_t<decltype(std::declval<View>().r)>;
    using Scalar = typename Positions::Scalar;
    static constexpr int dim = flat != 0 ? flat : int{Positions::RowsAtCompileTime};
    static_assert(dim == 2 || dim == 3,
                  "phistep: Pairs needs particles as columns of a 2 x N or 3 x N matrix; for one flat vector write "
                  "pairs<dim>(law, cutoff)");
    static_assert(!Positions::IsRowMajor || Positions::IsVectorAtCompileTime,
                  "phistep: Pairs needs particles as columns of a column-major matrix");
    static constexpr bool tagged = !std::is_invocable_v<const Law&, Scalar>;
    using Pack = phistep::Pack<Scalar, native_width<Scalar>>;
    static_assert(
        std::is_invocable_v<const Law&, Pack> || std::is_invocable_v<const Law&, Pack, Pack, Pack>,
        "phistep: a pair law takes r^2 of several pairs at once and returns F/r: [](auto r2) { return ...; }");
  };
  template <class View>
  static constexpr bool offers_energy = requires(const Law& l, typename Shape<View>::Scalar x) {
    l.energy(x);
  }
  || requires(const Law& l, typename Shape<View>::Scalar x) { l.energy(x, x, x); };

 public:
  static constexpr const char* name = "pairs";  ///< of its memory, in checkpoints
  using Memory = NeighborMemory;
  static constexpr Structure structure = Structure::network;
  static constexpr bool uses_velocity = false, uses_time = false, computes_active_only = true;
  static constexpr bool has_edges = true, is_symmetric = true;
  static constexpr int block = flat;  // where that is 0, the state's
  /// The law has a cutoff for each pair of types, as ByType may.
  static constexpr bool own_cutoffs = requires(const Law& l) { l.cutoffs(); };

  Law law;  ///< g(r²) = F/r, and its energy where it has one

  /// @param cutoff  r_c [length]: no force from there on
  /// @throws std::invalid_argument unless it is finite and > 0, and the skin finite and >= 0
  explicit Pairs(Law pair_law, double cutoff, PairOptions options = {}) requires(!own_cutoffs)
      : law(std::move(pair_law)), range_{range_of(cutoff, options)} {}
  /// With the law's own cutoffs, of which one at least must be > 0.
  explicit Pairs(Law pair_law, PairOptions options = {}) requires(own_cutoffs)
      : law(std::move(pair_law)), range_{range_of(cutoff(), options)} {}

  void add(auto /*t*/, const auto& y, const Memory& memory, auto& out) const {
    using S = Shape<decltype(y)>;
    using P = typename S::Pack;
    using Scalar = typename S::Scalar;
    const NeighborList& list = gather<S>(y, memory);
    const ActiveSet* const active = active_set(y);
    const P rc2{limit<Scalar>()};
    for_each_row(list, [&](const NeighborList::Row& row, const NeighborList::Chunk& chunk, std::size_t) {
      const std::int32_t particle = list.particle_of(row.slot);
      if (active != nullptr && !active->has(particle)) return;
      Scalar* const to = out.force.data() + std::ptrdiff_t{S::dim} * particle;
      prefetch(to);
      P f[S::dim];
      unrolled<S::dim>([&](auto a) { f[a] = P{0}; });
      for_each_pack_of<S::dim, S::tagged, P>(row, chunk, place<Scalar>(0), [&](const P* d, P r2, auto&&... tags) {
        const P g = select(r2 < rc2, P{law(min(r2, rc2), tags...)}, P{0});
        unrolled<S::dim>([&](auto a) { f[a] = fma(g, d[a], f[a]); });
      });
      const Scalar* const x = place<Scalar>(row.slot);
      unrolled<S::dim>([&](auto a) { to[a] += sum(f[a]) + (x[a] - x[a]); });  // NaN where the position is none
    });
  }
  void commit(auto /*t*/, const auto& /*y*/, Memory& memory) const {
    memory.age += memory.age < std::numeric_limits<std::int32_t>::max();
  }

  /// Σ V over all pairs [energy] but those of two held still. By the list of a stepper's memory, or the one at hand if that serves.
  template <class View>
    requires offers_energy<View>
  [[nodiscard]] auto energy(auto /*t*/, const View& y, const Memory& memory = {}) const {
    return total(y, memory, [this](auto, auto r2, auto... tags) { return law.energy(r2, tags...); });
  }
  /// Σ r·f over the same pairs [energy], for the pressure: p V = N k T + Σ/dim
  [[nodiscard]] auto virial(auto /*t*/, const auto& y, const Memory& memory = {}) const {
    return total(y, memory, [this](auto, auto r2, auto... tags) { return r2 * law(r2, tags...); });
  }
  /// How many of them are closer than the cutoff. With the memory of an unchecked list: without those that it misses.
  [[nodiscard]] std::uint64_t pairs_inside(const auto& y, const Memory& memory = {}) const {
    return static_cast<std::uint64_t>(total(y, memory, [this](auto one, [[maybe_unused]] auto... r2_and_tags) {
      if constexpr (own_cutoffs) return law.reaches(r2_and_tags...);
      else return one;
    }));
  }

  /// Every listed pair, those beyond the cutoff with tangents of 0: what couples to what changes with the list alone.
  void add_jacobian(auto /*t*/, const auto& y, const Memory& memory, auto& sink) const {
    using S = Shape<decltype(y)>;
    using Scalar = typename S::Scalar;
    const NeighborList& list = gather<S>(y, memory);
    const auto rc2 = limit<Scalar>();
    memory.is_pattern = true;
    list.for_each_neighbor([&](const NeighborList::Row& row, std::int32_t slot) {
      const std::int32_t i = list.particle_of(row.slot), j = list.particle_of(slot);
      if (j == i || (j < i && !is_still(y, j))) return;  // an own image moves along
      const Scalar *const xi = place<Scalar>(row.slot), *const xj = place<Scalar>(slot);
      Scalar n[S::dim], r2{0};
      for (int a = 0; a < S::dim; ++a) n[a] = xj[a] - xi[a], r2 += n[a] * n[a];
      PairTangent<Scalar> K;
      if (!(r2 >= rc2)) {
        Dual<Scalar> g{r2, Scalar{1}};
        if constexpr (S::tagged) g = law(g, xi[3], xj[3]);
        else g = law(g);
        K = {-(g.x + 2 * r2 * g.slope), -g.x};
      }
      const Scalar inverse = r2 > 0 ? 1 / std::sqrt(r2) : Scalar{0};
      for (Scalar& component : n) component *= inverse;
      put_pair<S::dim, false>(sink, Eigen::Index{i}, Eigen::Index{j}, n, K, {});
    });
  }

  /// f(i, j) for every listed pair, by the user's indices: all that may act before pair_changes() changes.
  void for_each_pair(const Memory& /*memory*/, auto&& f) const {
    for (const NeighborList* list : {&work_.two.current(), &work_.three.current()}) {
      list->for_each_neighbor([&](const NeighborList::Row& row, std::int32_t slot) {
        f(Eigen::Index{list->particle_of(row.slot)}, Eigen::Index{list->particle_of(slot)});
      });
    }
  }
  [[nodiscard]] std::uint64_t pair_changes() const { return rebuilds(); }
  /// The longest, where pairs have their own.
  [[nodiscard]] double cutoff() const {
    if constexpr (own_cutoffs) return *std::max_element(law.cutoffs().begin(), law.cutoffs().end());
    else return range_.cutoff;
  }
  /// Of the list in use; before the first, the one it starts with.
  [[nodiscard]] double skin() const {
    const double now = std::max(work_.three.skin(), work_.two.skin());
    return now > 0 ? now : range_.skin;
  }
  /// Lists made; distances computed and neighbours found by the last one.
  [[nodiscard]] std::uint64_t rebuilds() const { return work_.three.rebuilds() + work_.two.rebuilds(); }
  [[nodiscard]] std::uint64_t pairs_tested() const { return work_.three.pairs_tested() + work_.two.pairs_tested(); }
  [[nodiscard]] std::uint64_t pairs_listed() const { return work_.three.pairs_listed() + work_.two.pairs_listed(); }

 private:
  struct Work {
    Neighbors<2, own_cutoffs> two;
    Neighbors<3, own_cutoffs> three;
    std::tuple<Places<float>, Places<double>, Places<long double>> places;
    std::vector<double> partial;
    TypeCutoffs own;
  };

  [[nodiscard]] static NeighborRange range_of(double cutoff, const PairOptions& options) {
    if (!(cutoff > 0) || !std::isfinite(cutoff))
      throw std::invalid_argument("phistep: a cutoff must be finite and > 0");
    if (!(options.skin >= 0) || !std::isfinite(options.skin))
      throw std::invalid_argument("phistep: a skin must be finite and >= 0");
    if (options.unchecked_every < 0) throw std::invalid_argument("phistep: a list is made anew every n >= 1 steps");
    return {cutoff, options.skin == 0 ? 0.16 * cutoff : options.skin, options.unchecked_every, 1,
            options.skin == 0 && options.unchecked_every == 0};
  }

  template <class Scalar>
  [[nodiscard]] const Scalar* place(std::int32_t slot) const {
    return std::get<Places<Scalar>>(work_.places).data() + std::ptrdiff_t{4} * slot;
  }
  template <class Scalar>
  [[nodiscard]] Scalar limit() const {
    return static_cast<Scalar>(cutoff() * cutoff());
  }

  /// The neighbour list for y. Fills work_.places: where each slot is.
  /// @param borrows  an empty memory takes the list made last, if that serves
  template <class S>
  const NeighborList& gather(const auto& y, const Memory& memory, bool borrows = false) const {
    using Scalar = typename S::Scalar;
    const Eigen::Index n = y.r.size() / S::dim;
    const Scalar* const r = y.r.data();
    if (!(limit<Scalar>() >= least_normal<Scalar> && cutoff() < far_away<Scalar>() / 2))
      throw std::invalid_argument("phistep: a cutoff whose square these numbers can't hold");
    Domain domain;
    static const std::vector<std::uint8_t> none;
    const std::vector<std::uint8_t>* still = &none;
    if constexpr (HasBody<decltype(y)>) domain = domain_of(y.body.box), still = &y.body.still;
    auto& neighbors = std::get<Neighbors<S::dim, own_cutoffs>&>(std::tie(work_.two, work_.three));
    NeighborRange range = range_;
    range.pad = native_width<Scalar>;
    if constexpr (own_cutoffs) {
      work_.own.type.resize(static_cast<std::size_t>(n));
      for (Eigen::Index i = 0; i < n; ++i) work_.own.type[static_cast<std::size_t>(i)] = law.tag(y.body, i);
      work_.own.cutoffs = law.cutoffs();
      range.cutoff = cutoff(), range.own = &work_.own;
    }
    if (borrows && !memory.reference) memory.reference = neighbors.made_from(), range.unchecked_every = 0;
    const NeighborList& list = neighbors.list(r, n, domain, *still, range, memory);
    auto& places = std::get<Places<Scalar>>(work_.places);
    gather_places<S::dim>(list, r, domain, places);
    if constexpr (S::tagged)  // by one thread: it may throw
      for (std::size_t s = 0; s < list.slots.size(); ++s) {
        const std::ptrdiff_t particle = list.slots[s].particle;
        if (particle >= 0) places(3, static_cast<Eigen::Index>(s)) = static_cast<Scalar>(law.tag(y.body, particle));
      }
    return list;
  }

  /// Σ over pairs of value(1, r²[, tags]), each once.
  template <class View>
  [[nodiscard]] auto total(const View& y, Memory memory, auto&& value) const {
    using S = Shape<View>;
    using Scalar = typename S::Scalar;
    using P = typename S::Pack;
    const NeighborList& list = gather<S>(y, memory, true);
    const auto rc2 = limit<Scalar>();
    work_.partial.assign(list.chunk_count, 0);
    // A row sees every pair of two that move twice, one with a particle held still once.
    bool all_move = true;
    if constexpr (HasBody<View>) all_move = y.body.still.empty();
    for_each_row(list, [&](const NeighborList::Row& row, const NeighborList::Chunk& chunk, std::size_t number) {
      double& to = work_.partial[number];
      const auto inside = [&]<class Q>(const Q*, Q r2, auto... tags) {
        return select(r2 < Q{rc2}, Q{value(Q{1}, min(r2, Q{rc2}), tags...)}, Q{0});
      };
      if (all_move) {
        P row_sum{0};
        for_each_pack_of<S::dim, S::tagged, P>(
            row, chunk, place<Scalar>(0), [&](const P* d, P r2, auto... tags) { row_sum += inside(d, r2, tags...); });
        to += static_cast<double>(sum(row_sum)) / 2;
      } else {
        using One = phistep::Pack<Scalar, 1>;
        list.for_each_neighbor(row, chunk, [&](std::int32_t slot) {
          const bool once = is_still(y, list.particle_of(slot));
          with_pack<S::dim, S::tagged>(broadcast_place<One>(place<Scalar>(row.slot)), place<Scalar>(0), &slot,
                                       [&](const One* d, One r2, auto... tags) {
                                         to += static_cast<double>(inside(d, r2, tags...)[0]) / (once ? 1 : 2);
                                       });
        });
      }
      const Scalar* const x = place<Scalar>(row.slot);
      for (int a = 0; a < S::dim; ++a) to += static_cast<double>(x[a] - x[a]);
    });
    double all = 0;
    for (const double part : work_.partial) all += part;
    return static_cast<Scalar>(all);
  }

  NeighborRange range_;
  mutable Scratch<Work> work_;
};

/// For positions in one flat vector (x₀ y₀ [z₀] x₁ …).
template <int dim, class Law>
[[nodiscard]] Pairs<Law, dim> pairs(Law law, double cutoff, PairOptions options = {}) {
  return Pairs<Law, dim>{std::move(law), cutoff, options};
}

}}  // namespace phistep::PHISTEP_ABI
