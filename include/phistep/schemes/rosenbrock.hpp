/// @file
/// Rosenbrock schemes: linearly implicit Runge-Kutta steps, whose stages are linear equations with one matrix
/// (H. H. Rosenbrock, Comput. J. 5 (1963) 329; Hairer & Wanner, Solving ODEs II, sect. IV.7, eq. 7.25):
///
///     Y_i = y + Σ_{j<i} a_ij u_j                                                                                (1)
///     (M − γΔtJ) u_i = γΔt Ψ(t + α_iΔt, Y_i) + γM Σ_{j<i} c_ij u_j + γγ_iΔt² Ψ_t(t, y)                          (2)
///     y⁺ = Y_s + u_s                                                                                            (3)
///
/// with J = Ψ_y(t, y). (3) is how a stiffly accurate scheme ends: Y_s is itself a solution of the embedded order, so that
/// the last u_s estimates the error. J must be the Jacobian, or the order is lost: an analytic one, automatic
/// differentiation or differences. For motion, y = (r, v), the solves are of n unknowns (linear_stages.hpp).
#pragma once

#include <array>
#include <type_traits>
#include <utility>

#include "phistep/base/facts/scheme_facts.hpp"
#include "phistep/base/machine/memory.hpp"
#include "phistep/base/outcome/outcome.hpp"
#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/combination.hpp"
#include "phistep/base/state/unknowns.hpp"
#include "phistep/step/kernel/scheme_on.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

// Coefficients of schemes that are stiffly accurate and L-stable: a and c of (1) and (2), α_i and γ_i, weights of a dense output.

/// A Rosenbrock scheme of s stages. @tparam Tableau  Rodas4, Rodas4P2 or Rodas5P
template <class Tableau>
struct Rosenbrock {
  static constexpr SchemeFacts facts = AStable{.is_l_stable = true, .energy = EnergyBalance::rest};
  [[nodiscard]] static constexpr int order() { return Tableau::order; }
  [[nodiscard]] static constexpr const char* name() { return Tableau::name; }
};

/// RODAS of order 4(3), six stages, six force calls: Hairer & Wanner, Solving ODEs II, sect. IV.10, and their program's
/// dense output of order 3.
struct Rodas4 {
  static constexpr const char* name = "rodas4";
  static constexpr int stages = 6, order = 4, dense = 2;
  static constexpr long double gamma = 0.25L;
  static constexpr long double a[stages][stages] = {
      {},
      {1.544L},
      {0.9466785280815826L, 0.2557011698983284L},
      {3.314825187068521L, 2.896124015972201L, 0.9986419139977817L},
      {1.221224509226641L, 6.019134481288629L, 12.53708332932087L, -0.687886036105895L},
      {1.221224509226641L, 6.019134481288629L, 12.53708332932087L, -0.687886036105895L, 1}};
  static constexpr long double c[stages][stages] = {
      {},
      {-5.6688L},
      {-2.430093356833875L, -0.2063599157091915L},
      {-0.1073529058151375L, -9.594562251023355L, -20.47028614809616L},
      {7.496443313967647L, -10.24680431464352L, -33.99990352819905L, 11.7089089320616L},
      {8.083246795921522L, -7.981132988064893L, -31.52159432874371L, 16.31930543123136L, -6.058818238834054L}};
  static constexpr long double alpha[stages] = {0, 0.386L, 0.21L, 0.63L, 1, 1};
  static constexpr long double gammas[stages] = {0.25L, -0.1043L, 0.1035L, -0.0362L, 0, 0};
  static constexpr long double inside[dense][stages] = {
      {10.12623508344586L, -7.487995877610167L, -34.80091861555747L, -7.992771707568823L, 1.025137723295662L},
      {-0.6762803392801253L, 6.087714651680015L, 16.43084320892478L, 24.76722511418386L, -6.594389125716872L}};
};

/// Rodas4P2 of order 4(3), six stages, six force calls, and a dense output of order 3: G. Steinebach, "Improvement of
/// Rosenbrock-Wanner method RODASP", in: T. Reis et al., Progress in Differential-Algebraic Equations II (Springer 2020)
/// 165. Also fulfils the conditions of Prothero and Robinson's problem and of semi-discretised parabolic ones, so that neither
/// the step nor its estimate loses order where the stiff part is driven by time.
struct Rodas4P2 {
  static constexpr const char* name = "rodas4p2";
  static constexpr int stages = 6, order = 4, dense = 2;
  static constexpr long double gamma = 0.25L;
  static constexpr long double a[stages][stages] = {
      {},
      {3},
      {0.906377755268814L, -0.189707390391685L},
      {3.758617027739064L, 1.161741776019525L, -0.849258085312803L},
      {7.089566927282776L, 4.573591406461604L, -8.423496976860259L, -0.959280113459775L},
      {7.089566927282776L, 4.573591406461604L, -8.423496976860259L, -0.959280113459775L, 1}};
  static constexpr long double c[stages][stages] = {
      {},
      {-12},
      {-6.354581592719008L, 0.338972550544623L},
      {-8.575016317114033L, -7.606483992117508L, 12.224997650124820L},
      {-5.888975457523102L, -8.157396617841821L, 24.805546872612922L, 12.790401512796979L},
      {-4.408651676063871L, -6.692003137674639L, 24.625568527593117L, 16.627521966636085L, -5.714285714285718L}};
  static constexpr long double alpha[stages] = {0, 0.75L, 0.321448134013046L, 0.519745732277726L, 1, 1};
  static constexpr long double gammas[stages] = {0.25L, -0.5L, -0.189532918363016L, 0.085612108792769L, 0, 0};
  static constexpr long double inside[dense][stages] = {
      {-5.323528268423303L, -10.042123754867493L, 17.175254928256965L, -5.079931171878093L, -0.016185991706112L},
      {6.984505741529879L, 6.914061169603662L, -0.849178943070653L, 18.104410789349338L, -3.516963011559032L}};
};

/// Rodas5P of order 5(4), eight stages, eight force calls, and a dense output of order 4: G. Steinebach, BIT Numer. Math.
/// 63 (2023) 27. Keeps its order on Prothero and Robinson's problem and semi-discretised parabolic ones better than others.
struct Rodas5P {
  static constexpr const char* name = "rodas5p";
  static constexpr int stages = 8, order = 5, dense = 3;
  static constexpr long double gamma = 0.21193756319429014L;
  static constexpr long double a[stages][stages] = {
      {},
      {3},
      {2.849394379747939L, 0.45842242204463923L},
      {-6.954028509809101L, 2.489845061869568L, -10.358996098473584L},
      {2.8029986275628964L, 0.5072464736228206L, -0.3988312541770524L, -0.04721187230404641L},
      {-7.502846399306121L, 2.561846144803919L, -11.627539656261098L, -0.18268767659942256L, 0.030198172008377946L},
      {-7.502846399306121L, 2.561846144803919L, -11.627539656261098L, -0.18268767659942256L, 0.030198172008377946L, 1},
      {-7.502846399306121L, 2.561846144803919L, -11.627539656261098L, -0.18268767659942256L, 0.030198172008377946L, 1,
       1}};
  static constexpr long double c[stages][stages] = {
      {},
      {-14.155112264123755L},
      {-17.97296035885952L, -2.859693295451294L},
      {147.12150275711716L, -1.41221402718213L, 71.68940251302358L},
      {165.43517024871676L, -0.4592823456491126L, 42.90938336958603L, -5.961986721573306L},
      {24.854864614690072L, -3.0009227002832186L, 47.4931110020768L, 5.5814197821558125L, -0.6610691825249471L},
      {30.91273214028599L, -3.1208243349937974L, 77.79954646070892L, 34.28646028294783L, -19.097331116725623L,
       -28.087943162872662L},
      {37.80277123390563L, -3.2571969029072276L, 112.26918849496327L, 66.9347231244047L, -40.06618937091002L,
       -54.66780262877968L, -9.48861652309627L}};
  static constexpr long double alpha[stages] = {
      0, 0.6358126895828704L, 0.4095798393397535L, 0.9769306725060716L, 0.4288403609558664L, 1, 1, 1};
  static constexpr long double gammas[stages] = {0.21193756319429014L,
                                                 -0.42387512638858027L,
                                                 -0.3384627126235924L,
                                                 1.8046452872882734L,
                                                 2.325825639765069L,
                                                 0,
                                                 0,
                                                 0};
  static constexpr long double inside[dense][stages] = {
      {25.948786856663858L, -2.5579724845846235L, 10.433815404888879L, -2.3679251022685204L, 0.524948541321073L,
       1.1241088310450404L, 0.4272876194431874L, -0.17202221070155493L},
      {-9.91568850695171L, -0.9689944594115154L, 3.0438037242978453L, -24.495224566215796L, 20.176138334709044L,
       15.98066361424651L, -6.789040303419874L, -6.710236069923372L},
      {11.419903575922262L, 2.8879645146136994L, 72.92137995996029L, 80.12511834622643L, -52.072871366152654L,
       -59.78993625266729L, -0.15582684282751913L, 4.883087185713722L}};
};

/// Order 4, stiff problems at 2 to 4 digits: a step is a Jacobian, a factorization and six linear solves, no iteration. Take
/// `rodas4p2`: as fast within a fifth or faster, and without this one's loss of digits to rounding over many decades (E5).
inline constexpr Rosenbrock<Rodas4> rodas4{};
/// Order 4, stiff problems at 2 to 4 digits, also those that are driven by time: in place of `rodas4`, at the same cost a step.
inline constexpr Rosenbrock<Rodas4P2> rodas4p2{};
/// Order 5, stiff problems at 4 to 8 digits where there are many unknowns: eight solves.
inline constexpr Rosenbrock<Rodas5P> rodas5p{};

template <class Tableau, State S>
class SchemeOn<Rosenbrock<Tableau>, S> : public SchemeDefaults {
 public:
  using Scalar = ScalarOf<S>;
  using Plain = PlainState<S>;
  template <class Rhs>
  static constexpr KernelNeeds needs{.carries = can_carry<Rhs>, .stages = true};
  static constexpr std::size_t stages = Tableau::stages;

  SchemeOn(Rosenbrock<Tableau>, const Plain& y) { resize(y); }
  void resize(const Plain& y) {
    if constexpr (!on_stack) u_.fill(y), weighted_ = y;
    inside_.fill(y);
  }
  [[nodiscard]] static int order() { return Tableau::order; }
  [[nodiscard]] static int error_order() { return Tableau::order; }

  [[nodiscard]] static bool takes_singular_mass() { return true; }
  static constexpr bool traces = true;
  [[nodiscard]] static bool estimates(const auto&) { return true; }
  [[nodiscard]] static bool leaves_force() { return false; }  // the last Ψ is that at stage Y_s, not at the step's end

  [[nodiscard]] Outcome step(auto& eq) {
    return with_stages([&](auto& u, Plain& weighted) {
      if (const Outcome bad = all(eq, u, weighted, All{}); failed(bad)) return bad;
      eq.tell([&](auto& trace) {
        copy_blocks<S>(trace.error, u[stages - 1]);
        trace.has_error = true;
        if (trace.wants_dense) keep_inside(u, std::make_index_sequence<Tableau::dense>{});
      });
      const Scalar gamma = static_cast<Scalar>(Tableau::gamma) * eq.dt;
      if (const Outcome bad = eq.see_falling_rates({gamma, gamma}, true); failed(bad)) return bad;
      return eq.look_at_end();
    });
  }

  static constexpr bool interpolates = Tableau::dense > 0;
  /// y(t + xΔt) = (1−x) y + x {y⁺ + (1−x) [k₁ + x (k₂ + x k₃)]}, k = Σ_j h_j u_j
  void interpolate(Scalar x, Scalar, const Plain& y0, const Plain& y1, Plain& out) const {
    copy_blocks<S>(out, inside_[Tableau::dense - 1]);
    const auto k = in<S>(out), start = in<S>(y0), end = in<S>(y1);
    for (std::size_t j = inside_.size() - 1; j-- > 0;) assign<S>(out, in<S>(inside_[j]) + x * k);
    assign<S>(out, (1 - x) * start + x * (end + (1 - x) * k));
  }

 private:
  static constexpr bool on_stack = fits_registers<S>;

  /// f(u, scratch): a small state's stages live in registers.
  [[nodiscard]] Outcome with_stages(auto&& f) {
    if constexpr (on_stack) {
      std::array<Plain, stages> u;
      Plain weighted;
      return f(u, weighted);
    } else {
      return f(u_, weighted_);
    }
  }

  using All = std::make_index_sequence<stages>;
  template <const auto& table, std::size_t i, std::size_t n = i>
  [[nodiscard]] static auto sum(const std::array<Plain, stages>& u) {
    return weighted_sum<S, TableRow<table, i, n>>(u);
  }
  template <std::size_t... k>
  void keep_inside(const auto& u, std::index_sequence<k...>) {
    (assign<S>(inside_[k], sum<Tableau::inside, k, stages>(u)), ...);
  }
  /// Whether Y_i = Y_{i−1} + u_{i−1}.
  [[nodiscard]] static constexpr bool follows(std::size_t i) {
    for (std::size_t j = 0; j < i; ++j)
      if (Tableau::a[i][j] != (j == i - 1 ? 1 : Tableau::a[i - 1][j])) return false;
    return i > 0;
  }

  template <class Eq, std::size_t... i>
  [[nodiscard]] static Outcome all(Eq& eq, auto& u, Plain& weighted, std::index_sequence<i...>) {
    if (const Outcome outcome = eq.linearize(); outcome != Outcome::success) return outcome;
    const Scalar gamma = static_cast<Scalar>(Tableau::gamma) * eq.dt;
    if (const Outcome outcome = eq.factorize(gamma); outcome != Outcome::success) return outcome;
    if (const Outcome bad = eq.check_start({gamma, gamma}); failed(bad)) return bad;
    Outcome outcome = Outcome::success;
    static_cast<void>(((outcome = stage<i>(eq, gamma, u, weighted), outcome == Outcome::success) && ...));
    if (outcome != Outcome::success) return outcome;
    add<S>(eq.next, in<S>(u[stages - 1]));  // (3)
    if (Eq::Rhs::is_finite(eq.next)) return Outcome::success;
    static_cast<void>((blame<i>(eq, u) || ...));
    return Outcome::non_finite_state;
  }
  /// Where u_i isn't finite: leaves Y_i and Ψ there for the failure message.
  template <std::size_t i>
  [[nodiscard, gnu::cold, gnu::noinline]] static bool blame(auto& eq, const auto& u) {
    if (all_finite(Blocks<S>::all(u[i]))) return false;
    if constexpr (i > 0) {
      assign<S>(eq.next, in<S>(eq.y) + sum<Tableau::a, i>(u));
      eq.evaluate(eq.t + static_cast<Scalar>(Tableau::alpha[i]) * eq.dt, eq.next);
    }
    return true;
  }

  template <std::size_t i, class Eq>
  [[nodiscard]] static Outcome stage(Eq& eq, Scalar gamma, auto& u, Plain& weighted) {
    Plain &Y = eq.next, &b = u[i];
    const auto psi = in_rate<S>(eq.psi);
    if constexpr (i == 0) {
      copy_blocks<S>(Y, eq.y);
      assign_solved<S>(b, gamma * psi);
      if constexpr (Blocks<S>::drifts) position_of<S>(b) = gamma * velocity_of<S>(Y);
    } else {
      if constexpr (follows(i)) add<S>(Y, in<S>(u[i - 1]));
      else assign<S>(Y, in<S>(eq.y) + sum<Tableau::a, i>(u));  // (1)
      eq.evaluate(eq.t + static_cast<Scalar>(Tableau::alpha[i]) * eq.dt, Y);
      assign<S>(weighted, sum<Tableau::c, i>(u));
      assign_solved<S>(b, gamma * psi);
      eq.add_mass_product(b, static_cast<Scalar>(Tableau::gamma), weighted);
      if constexpr (Blocks<S>::drifts)
        position_of<S>(b) = gamma * velocity_of<S>(Y) + static_cast<Scalar>(Tableau::gamma) * position_of<S>(weighted);
    }
    if constexpr (Eq::has_time && Tableau::gammas[i] != 0)
      add_solved<S>(b, gamma * static_cast<Scalar>(Tableau::gammas[i]) * eq.dt * in_rate<S>(eq.psi_t()));
    if constexpr (i == stages - 1) eq.keep_unfiltered_product(b);
    return solve<i>(eq, gamma, u);
  }

  /// κ_i = 1 + γ Σ_{j<i} c_ij κ_j: where Ψ doesn't change during the step, u_i = κ_i u_1.
  [[nodiscard]] static constexpr long double kappa(std::size_t i) {
    long double sum = 1;
    for (std::size_t j = 0; j < i; ++j) sum += Tableau::gamma * Tableau::c[i][j] * kappa(j);
    return sum;
  }
  /// Solves (2) for u_i, whose place holds the right-hand side b_i before. An iterative solver begins with κ_i u_1:
  /// (M − γΔtJ)(u_i − κ_i u_1) = b_i − κ_i b_1. κ_s = 0, so that the place of u_s can hold b_1 up to the last stage.
  template <std::size_t i, class Eq>
  [[nodiscard]] static Outcome solve(Eq& eq, Scalar gamma, auto& u) {
    constexpr long double share = kappa(i), none = 1e-6L;
    using Stages = std::remove_cvref_t<decltype(eq.stages())>;
    if constexpr (Stages::iterates && (share > none || share < -none)) {
      static_assert(kappa(stages - 1) < none && kappa(stages - 1) > -none);
      if (eq.stages().follows_error()) {
        if constexpr (i > 0) {
          const auto by = static_cast<Scalar>(share);
          add<S>(u[i], -by * in<S>(u[stages - 1]));
          if (const Outcome bad = eq.solve(gamma, u[i]); failed(bad)) return bad;
          add<S>(u[i], by * in<S>(u[0]));
          return Outcome::success;
        }
        copy_blocks<S>(u[stages - 1], u[0]);
      }
    }
    return eq.solve(gamma, u[i]);
  }

  [[no_unique_address]] Only<!on_stack, std::array<Plain, stages>> u_;
  [[no_unique_address]] Only<!on_stack, Plain> weighted_;
  std::array<Plain, static_cast<std::size_t>(Tableau::dense)> inside_;
};

}}  // namespace phistep::PHISTEP_ABI
