// The concepts, by yes and by no. (Must-not-compile cases: tests/compile.)
#include <complex>
#include <functional>
#include <string>
#include <vector>

#include "contract/states.hpp"
#include "support/catch.hpp"
#if PHISTEP_QUICK
#include <phistep/sparse.hpp>
#endif
#if PHISTEP_FULL
#include <phistep/phistep.hpp>
#endif

using namespace phistep;
using namespace states;

#if PHISTEP_QUICK

// ---- State ----------------------------------------------------------------------------------------------------------
static_assert(State<Fixed> && State<Dynamic> && State<Columns> && State<RowMajor> && State<Eigen::ArrayXd> &&
              State<Eigen::RowVectorXd>);
static_assert(State<Mapped> && State<Strided> && State<Structs> && State<Reference>);
static_assert(State<Motion<Fixed>> && State<Motion<Strided>> && State<Warm>);
static_assert(State<Eigen::VectorXf> && State<Eigen::Matrix<long double, 2, 1>>);
static_assert(!State<double> && !State<std::vector<double>> && !State<std::string> && !State<double*>);
static_assert(!State<Eigen::SparseMatrix<double>>);
static_assert(!State<decltype(std::declval<Dynamic&>() + std::declval<Dynamic&>())>);  // an expression holds no memory

struct NoRate {
  Eigen::VectorXd r, v;
  static constexpr bool drifts = true;
  static auto blocks(auto& y) { return std::tie(y.r, y.v); }
};
struct NoDrifts {
  Eigen::VectorXd y;
  static auto blocks(auto& s) { return std::tie(s.y); }
  struct Rate {
    Eigen::VectorXd rate;
    static auto blocks(auto& q) { return std::tie(q.rate); }
  };
};
static_assert(!State<NoRate> && State<NoDrifts> && !Blocks<NoDrifts>::drifts);

// ---- Scheme ---------------------------------------------------------------------------------------------------------
using PlainRhs = RightHandSide<Fixed, Fixed (*)(const Fixed&), std::tuple<UnitMass>>;
using PlainKernel = Kernel<Fixed, PlainRhs, Newton<>, KernelNeeds{.solver = true}>;
using Trapezoidal = SchemeOn<std::remove_const_t<decltype(trapezoidal)>, Fixed>;
static_assert(StepsOn<Trapezoidal, Fixed, PlainKernel> && Trapezoidal::traces);

struct Still1 : SchemeDefaults {  // a scheme that goes nowhere
  static Outcome step(auto&) { return Outcome::success; }
  static int order() { return 0; }
};
static_assert(StepsOn<Still1, Fixed, PlainKernel>);
struct Orderless : SchemeDefaults {
  static Outcome step(auto&) { return Outcome::success; }
};
struct NoOutcome : Still1 {
  static bool step(auto&) { return true; }
};
struct Boaster : Still1 {  // traces, and can't say whether it knows an error
  static constexpr bool traces = true;
};
struct Guesser : Still1 {  // interpolates, and has nothing to do it with
  static constexpr bool interpolates = true;
};
static_assert(!StepsOn<Orderless, Fixed, PlainKernel> && !StepsOn<NoOutcome, Fixed, PlainKernel>);
static_assert(!StepsOn<Boaster, Fixed, PlainKernel> && !StepsOn<Guesser, Fixed, PlainKernel>);

// ---- Mass -----------------------------------------------------------------------------------------------------------
static_assert(BoundMass<UnitMass, double> && BoundMass<ScalarMass<float>, float> &&
              BoundMass<DiagonalMass<double>, double> && BoundMass<DenseMass<double>, double>);
static_assert(!BoundMass<double, double> && !BoundMass<Fixed, double>);

// ---- Linear system --------------------------------------------------------------------------------------------------
static_assert(LinearSystem<DenseSystem<double, 3, true, true>, double, 3>);
static_assert(LinearSystem<DiagonalSystem<float, Eigen::Dynamic, true, false>, float>);
struct Unsolved : DiagonalSystem<double, Eigen::Dynamic, true, true> {
  void solve(auto& x) { x.setZero(); }  // says nothing of how it went
};
static_assert(!LinearSystem<Unsolved, double> &&
              LinearSystem<DiagonalSystem<double, Eigen::Dynamic, true, true>, double>);

// ---- Force ----------------------------------------------------------------------------------------------------------
using Moving = MotionView<Dynamic, UnitMass>;
using Still = FirstOrderView<Dynamic, UnitMass>;
template <class F>
using OfMotion = ForceTraits<F, Moving, RateOf<Motion<Dynamic>>>;
template <class F>
using OfFirst = ForceTraits<F, Still, RateOf<Dynamic>>;

using R = decltype([](const Dynamic& r) -> Dynamic { return r; });
using RV = decltype([](const Dynamic& r, const Dynamic&) -> Dynamic { return r; });
using RVT = decltype([](const Dynamic& r, const Dynamic&, double) -> Dynamic { return r; });
using YT = decltype([](const Dynamic& y, double) -> Dynamic { return y; });
using TY = decltype([](double, const Dynamic& y) -> Dynamic { return y; });
using Nothing = decltype([]() -> Dynamic { return {}; });
using FourArguments = decltype([](const Dynamic& r, const Dynamic&, double, int) -> Dynamic { return r; });
using Generic = decltype([](const auto& r, const auto&) { return r; });
using FixedOnly = decltype([](const Eigen::Vector2d& r) -> Eigen::Vector2d { return r; });

static_assert(OfMotion<R>::valid && OfMotion<R>::arity == 1 && !OfMotion<R>::uses_velocity && !OfMotion<R>::uses_time);
static_assert(OfMotion<RV>::arity == 2 && OfMotion<RV>::uses_velocity && !OfMotion<RV>::uses_time);
static_assert(OfMotion<RVT>::arity == 3 && OfMotion<RVT>::uses_velocity && OfMotion<RVT>::uses_time);
static_assert(OfMotion<Generic>::arity == 2);
static_assert(OfMotion<std::function<Dynamic(const Dynamic&)>>::arity == 1);
static_assert(!OfMotion<YT>::valid && !OfMotion<TY>::valid && !OfMotion<Nothing>::valid &&
              !OfMotion<FourArguments>::valid);
static_assert(!OfMotion<int>::valid && !OfMotion<std::string>::valid);
static_assert(OfFirst<R>::arity == 1 && !OfFirst<R>::uses_time);
static_assert(OfFirst<YT>::arity == 2 && OfFirst<YT>::uses_time);
static_assert(!OfFirst<RV>::valid && !OfFirst<RVT>::valid && !OfFirst<TY>::valid && !OfFirst<Nothing>::valid);
static_assert(!OfFirst<FixedOnly>::valid ||
              OfFirst<FixedOnly>::arity == 1);  // Eigen converts; sizes are checked in the step

static_assert(OfMotion<LinearDrag>::accumulates && OfMotion<LinearDrag>::uses_velocity &&
              !OfMotion<LinearDrag>::uses_time);
static_assert(OfMotion<LinearDrag>::has_jacobian && OfMotion<LinearDrag>::structure == Structure::diagonal);
static_assert(OfMotion<Gravity<>>::structure == Structure::none && !OfMotion<Gravity<>>::uses_velocity);
static_assert(OfMotion<SpringNetwork<3>>::structure == Structure::network &&
              !OfMotion<SpringNetwork<3>>::uses_velocity);
static_assert(OfMotion<SpringNetwork<3>>::block == 3 && OfMotion<SpringNetwork<3>>::is_symmetric_network);
using Scene = decltype(SpringNetwork<3>{{}} + LinearDrag{1} + Gravity{Eigen::Vector3d{}});
static_assert(OfMotion<Scene>::structure == Structure::network && OfMotion<Scene>::is_symmetric_network);
static_assert(OfMotion<SpringNetwork<3, SpringDamping>>::uses_velocity);

struct AddsSilently {  // without traits it may use anything
  void add(double, const auto&, auto&) const {}
};
static_assert(OfMotion<AddsSilently>::uses_velocity && OfMotion<AddsSilently>::uses_time &&
              !OfMotion<AddsSilently>::has_jacobian);

struct Analytic {
  Dynamic operator()(const Dynamic& r) const { return r; }
  Eigen::MatrixXd jacobian(const Dynamic& r) const { return Eigen::MatrixXd::Identity(r.size(), r.size()); }
};
struct AnalyticSparse {
  Dynamic operator()(const Dynamic& r) const { return r; }
  Eigen::SparseMatrix<double> jacobian(const Dynamic& r) const {
    return Eigen::SparseMatrix<double>(r.size(), r.size());
  }
};
static_assert(OfMotion<Analytic>::has_jacobian && OfMotion<Analytic>::structure == Structure::dense);
static_assert(OfMotion<AnalyticSparse>::has_jacobian && OfMotion<AnalyticSparse>::structure == Structure::sparse);
static_assert(OfFirst<Analytic>::has_jacobian && !OfFirst<R>::has_jacobian && !OfMotion<R>::has_jacobian);

// ---- sums -----------------------------------------------------------------------------------------------------------
template <class A, class B>
concept CanAdd = requires(A a, B b) {
  a + b;
};
static_assert(CanAdd<LinearDrag, Gravity<>> && CanAdd<Term<R>, Term<RV>> && CanAdd<Sum<LinearDrag>, LinearDrag>);
static_assert(!CanAdd<R, RV> &&
              !CanAdd<LinearDrag, double>);  // LinearDrag + R says what is missing: compile/add_lambda

// ---- results that may be kept ----------------------------------------------------------------------------------------
static_assert(PlainResult<Dynamic> && PlainResult<const Dynamic&> && PlainResult<Eigen::Map<Dynamic>>);
static_assert(!PlainResult<decltype(2.0 * std::declval<const Dynamic&>())>);
static_assert(!PlainResult<decltype(-std::declval<const Dynamic&>())>);
static_assert(!PlainResult<double> && !PlainResult<std::vector<double>>);

// ---- reports --------------------------------------------------------------------------------------------------------
static_assert(sizeof(StepReport) <= 16 && std::is_trivially_copyable_v<StepReport>);
static_assert(!std::is_convertible_v<StepReport, bool> && std::is_constructible_v<bool, StepReport>);
static_assert(!std::is_convertible_v<RunReport, bool> && std::is_constructible_v<bool, RunReport>);

// ---- deduction: one spelling for all, without empty template brackets -------------------------------------------------
static_assert(std::is_same_v<decltype(newton()), Newton<>> &&
              std::is_same_v<decltype(newton({.rtol = 1e-6})), Newton<>>);
static_assert(std::is_same_v<decltype(Gravity{Eigen::Vector2d(0, -1)}), Gravity<Eigen::Vector2d>>);
static_assert(std::is_same_v<decltype(Gravity{{0, 0, -9.81}}), Gravity<Eigen::Vector3d>>);
static_assert(std::is_same_v<decltype(UniformForce{{0, 0, -9.81}}), UniformForce<Eigen::Vector3d>>);
static_assert(version_major == PHISTEP_VERSION_MAJOR && version_minor == PHISTEP_VERSION_MINOR);

TEST_CASE("every order of optional arguments that the documentation shows deduces") {
  STATIC_REQUIRE(requires(Dynamic & y, const R& force) {
    PhiStepper{y, force, trapezoidal};
    PhiStepper{y, force, trapezoidal, mass(2.0)};
    PhiStepper{y, force, trapezoidal, capacity(2.0)};
    PhiStepper{y, force, trapezoidal, newton({.rtol = 1e-6})};
    PhiStepper{y, force, trapezoidal, mass(2.0), newton()};
  });
}

#elif PHISTEP_FULL
// Every spelling of a stepper that the documentation shows.

using R = decltype([](const Dynamic& r) -> Dynamic { return r; });

TEST_CASE("every order of optional arguments that the documentation shows deduces") {
  Dynamic y = Dynamic::Ones(2);
  const R force{};
  CHECK(PhiStepper{y, force, trapezoidal}.step(y, 0, 0.1));
  CHECK(PhiStepper{y, force, trapezoidal, mass(2.0)}.step(y, 0, 0.1));
  CHECK(PhiStepper{y, force, trapezoidal, capacity(2.0)}.step(y, 0, 0.1));
  CHECK(PhiStepper{y, force, trapezoidal, newton({.rtol = 1e-6})}.step(y, 0, 0.1));
  CHECK(PhiStepper{y, force, trapezoidal, mass(2.0), newton()}.step(y, 0, 0.1));
}

#endif
