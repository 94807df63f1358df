/// @file
/// Published Runge-Kutta-Nyström pairs, for nystrom.hpp: a_ij, c_i, the rows b_j for r and b'_j for v, and the same with a hat for
/// the formula of lower order.
///
/// J. R. Dormand, M. E. A. El-Mikkawy & P. J. Prince, "High-order embedded Runge-Kutta-Nyström formulae", IMA J. Numer. Anal.
/// 7 (1987) 423. Fractions are as printed, or the printed fractions to 24 digits.
#pragma once

#include <array>
#include <cstddef>
#include <iterator>
#include <tuple>

#include "phistep/base/state/blocks.hpp"
#include "phistep/base/state/unknowns.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// RKN8(6)9FM: order 8 and 6, nine stages, the last at r⁺.
struct Rkn86 {
  static constexpr const char* name = "rkn86";
  static constexpr int stages = 9, order = 8, error_order = 7;
  static constexpr int dense[] = {0, 3, 4, 5, 6, 8};  // stages to interpolate
  static constexpr double doubtful[] = {0.22, 0.58};  // where v is then farthest off
  static constexpr bool first_is_last = true;
  static constexpr long double c[] = {0, 1.0L / 20, .1L, .3L, .5L, .7L, .9L, 1, 1};
  static constexpr long double a[][8] = {
      {0},
      {1.0L / 800},
      {1.0L / 600, 1.0L / 300},
      {9.0L / 200, -9.0L / 100, 9.0L / 100},
      {-66701.0L / 197352, 28325.0L / 32892, -2665.0L / 5482, 2170.0L / 24669},
      {227015747.0L / 304251000, -54897451.0L / 30425100, 12942349.0L / 10141700, -9499.0L / 304251, 539.0L / 9250},
      {-1131891597.0L / 901789000, 41964921.0L / 12882700, -6663147.0L / 3220675, 270954.0L / 644135, -108.0L / 5875,
       114.0L / 1645},
      {13836959.0L / 3667458, -17731450.0L / 1833729, 1063919505.0L / 156478208, -33213845.0L / 39119552,
       13335.0L / 28544, -705.0L / 14272, 1645.0L / 57088},
      {223.0L / 7938, 0, 1175.0L / 8064, 925.0L / 6048, 41.0L / 448, 925.0L / 14112, 1175.0L / 72576}};
  static constexpr long double b[][stages] = {
      {223.0L / 7938, 0, 1175.0L / 8064, 925.0L / 6048, 41.0L / 448, 925.0L / 14112, 1175.0L / 72576, 0, 0},
      {223.0L / 7938, 0, 5875.0L / 36288, 4625.0L / 21168, 41.0L / 224, 4625.0L / 21168, 5875.0L / 36288, 223.0L / 7938,
       0}};
  static constexpr long double b_hat[][stages] = {
      {7987313.0L / 109941300, 0, 1610737.0L / 44674560, 10023263.0L / 33505920, -497221.0L / 12409600,
       10023263.0L / 78180480, 1610737.0L / 402071040, 0, 0},
      {7987313.0L / 109941300, 0, 1610737.0L / 40207104, 10023263.0L / 23454144, -497221.0L / 6204800,
       10023263.0L / 23454144, 1610737.0L / 40207104, -4251941.0L / 54970650, 3.0L / 20}};
};

/// RKN12(10)17M: order 12 and 10, seventeen stages.
struct Rkn1210 {
  static constexpr const char* name = "rkn1210";
  static constexpr int stages = 17, order = 12, error_order = 11;
  static constexpr int dense[] = {0, 7, 8, 9, 10, 11, 12, 13, 14, 16};  // stages to interpolate
  static constexpr double doubtful[] = {0.12, 0.74};                    // where v is then farthest off
  static constexpr bool first_is_last = false;
  static constexpr long double c[] = {0,         1.0L / 50, 1.0L / 25,      .1L,      2.0L / 15, 4.0L / 25,
                                      1.0L / 20, 1.0L / 5,  1.0L / 4,       1.0L / 3, .5L,       5.0L / 9,
                                      .75L,      6.0L / 7,  8437.0L / 8926, 1,        1};
  static constexpr long double a[][16] = {
      {0},
      {.0002L},
      {.000266666666666666666666667L, .000533333333333333333333333L},
      {.00291666666666666666666667L, -.00416666666666666666666667L, .00625L},
      {.00164609053497942386831276L, 0, .00548696844993141289437586L, .00175582990397805212620027L},
      {.0019456L, 0, .00715174603174603174603175L, .00291271111111111111111111L, .000789942857142857142857143L},
      {.00056640625L, 0, .000880973048941798941798942L, -.000436921296296296296296296L, .000339006696428571428571429L,
       -.0000994646990740740740740741L},
      {.00308333333333333333333333L, 0, 0, .00177777777777777777777778L, .0027L, .00157828282828282828282828L,
       .0108606060606060606060606L},
      {.00365183937480112971375119L, 0, .00396517171407234306617557L, .00319725826293062822350093L,
       .00822146730685543536968702L, -.00131309269595723798362014L, .00977158696806486781562609L,
       .00375576906923283379487933L},
      {.00370724106871850081019566L, 0, .00508204585455528598076108L, .00117470800217541204473569L,
       -.021147629915126991499623L, .0601046369810788081222574L, .0201057347685061881846749L,
       -.0283507501229335808430367L, .0148795689185819327555906L},
      {.0351253765607334415311308L, 0, -.00861574919513847910340576L, -.00579144805100791652167632L,
       1.94555482378261584239439L, -3.43512386745651359636787L, -.109307011074752217583893L, 2.34963831189951663943202L,
       -.756009408687022978027191L, .109528972221569264246502L},
      {.0205277925374824966509721L, 0, -.00728644676448017991778248L, -.0021153556079618402406926L,
       .927580796872352224256768L, -1.65228248442573667907303L, -.0210795630056865698191914L,
       1.20653643262078715447709L, -.413714477001066141324662L, .0907987398280965375956796L,
       .00535555260053398504916871L},
      {-.143240788755455150458921L, 0, .0125287037730918172778464L, .00682601916396982712868112L,
       -4.79955539557438726550216L, 5.6986250439519414337917L, .755343036952364522249444L, -.127554878582810837175401L,
       -1.96059260511173843289133L, .918560905663526240976234L, -.238800855052844310534827L, .15911081357234215513874L},
      {.804501920552048948697231L, 0, -.0166585270670112451778516L, -.0214158340426297348117314L,
       16.8272359289624658702009L, -11.1728353571760979267883L, -3.37715929722632374148856L,
       -15.2433266553608456461818L, 17.1798357382154165620248L, -5.43771923982399464535414L, 1.38786716183646557551257L,
       -.592582773265281165347677L, .0296038731712973527961593L},
      {-.91329676669735808209625L, 0, .0024112725757805178392449L, .0176581226938617419820699L,
       -14.8516497797203838246129L, 2.15897086700457560030782L, 3.99791558311787990115283L, 28.4341518002322318984543L,
       -25.2593643549415984378843L, 7.733878542362237365534L, -1.89130289484786746103826L, 1.00148450702247178036686L,
       .00464119959910905190510518L, .011218755022148957033975L},
      {-.275196297205593938206065L, 0, .0366118887791549201342293L, .009789519688231562624651L,
       -12.2930623458862103042147L, 14.207226453937902694293L, 1.58664769067895368322482L, 2.45777353275959454390324L,
       -8.93519369440327190552259L, 4.37367273161340694839327L, -1.83471817654494916304344L, 1.15920852890614912078083L,
       -.0172902531653839221518003L, .019325977904460766672765L, .00520444293755499311184926L},
      {1.30763918474040575879995L, 0, .017364109189745841867088L, -.0185444564542657950243621L,
       14.8115220328677268968478L, 9.38317630848247090787922L, -5.2284261999445422541474L, -48.9512805258476508040093L,
       38.2970960343379225625584L, -10.5873813369759797091619L, 2.4332304376226276358512L, -1.04534060425754442848652L,
       .0717732095086725945198185L, .00216221097080827826905505L, .00700959575960251423699283L, 0}};
  static constexpr long double b[][stages] = {
      {.012127868517185414976889L, 0, 0, 0, 0, 0, .0862974625156887444363792L, .252546958118714719432343L,
       -.197418679932682303358308L, .203186919078972590809262L, -.0207758080777149166121934L,
       .109678048745020136250111L, .0380651325264665057344879L, .0116340688043242296440928L,
       .00465802970402487868693615L, 0, 0},
      {.012127868517185414976889L, 0, 0, 0, 0, 0, .0908394342270407836172413L, .315683697648393399290429L,
       -.263224906576909737811077L, .304780378618458886213892L, -.0415516161554298332243867L, .24677560967629530656275L,
       .152260530105866022937951L, .0814384816302696075086494L, .0850257119389081128008018L,
       -.009155189630077962873141L, .025L}};
  static constexpr long double b_hat[][stages] = {
      {.0170087019070069917527545L, 0, 0, 0, 0, 0, .07225933593083140694886L, .372026177326753045388211L,
       -.40182114500930352143934L, .335455068301351666696584L, -.131306501075331808430282L, .18943190661604865272266L,
       .0268408020400290479053692L, .0163056656059179238935181L, .00379998835669659456166597L, 0, 0},
      {.0170087019070069917527545L, 0, 0, 0, 0, 0, .0760624588745593757356421L, .465032721658441306735263L,
       -.53576152667907136191912L, .503182602452027500044876L, -.262613002150663616860564L, .426221789886109468625985L,
       .107363208160116191621477L, .114139659241425467254627L, .0693633866500486770090603L, .02L, 0}};
};

// A motion inside a Runge-Kutta-Nyström step: the polynomial through the accelerations k_j that the step knows at
// c_j ∈ [0, 1], L_j being Lagrange's polynomials, integrated twice, and bent to meet the end,
//
//     r(x) = r + xΔt v + Δt² Σ B_j(x) k_j + (3x²−2x³) δ_r + (x³−x²) Δt δ_v,    B_j" = L_j, B_j(0) = B_j'(0) = 0   (1)
//
// with δ_r, δ_v what is missing from r⁺, v⁺ at x = 1; v(x) is its derivative. No force is called. Errors of the inner
// stages' k_j are errors of (1): the tests measure its order.

/// The interpolant of the pair `Tableau`, whose `dense` names the stages to go through.
template <class Tableau>
class NystromInterpolant {
  static constexpr std::size_t nodes = std::size(Tableau::dense);
  using Weights = std::array<long double, nodes>;
  static constexpr long double node(std::size_t n) { return Tableau::c[Tableau::dense[n]]; }

  /// The coefficients of 1, x, x², … in each L_j.
  static constexpr auto lagrange = [] {
    std::array<Weights, nodes> all{};
    for (std::size_t j = 0; j < nodes; ++j) {
      all[j][0] = 1;
      std::size_t degree = 0;
      for (std::size_t k = 0; k < nodes; ++k) {
        if (k == j) continue;
        const long double by = 1 / (node(j) - node(k));
        ++degree;
        for (std::size_t m = degree + 1; m-- > 0;)
          all[j][m] = by * ((m > 0 ? all[j][m - 1] : 0) - (m < degree ? node(k) * all[j][m] : 0));
      }
    }
    return all;
  }();

  struct Integrals {
    Weights twice{}, once{};  ///< B_j, B_j'
    /// In long double: the coefficients alternate, and are large.
    constexpr explicit Integrals(long double x) {
      for (std::size_t j = 0; j < nodes; ++j) {
        for (std::size_t m = nodes; m-- > 0;) {
          const auto power = static_cast<long double>(m);
          twice[j] = twice[j] * x + lagrange[j][m] / ((power + 1) * (power + 2));
          once[j] = once[j] * x + lagrange[j][m] / (power + 1);
        }
        twice[j] *= x * x;
        once[j] *= x;
      }
    }
  };
  static constexpr Integrals at_end{1};

 public:
  /// out = (1) and its derivative at x, of the step dt from y0 to y1 with accelerations k.
  template <State S, class Rate, std::size_t stages>
  static void at(ScalarOf<S> x, ScalarOf<S> dt, const PlainState<S>& y0, const PlainState<S>& y1,
                 const std::array<Rate, stages>& k, PlainState<S>& out) {
    using Scalar = ScalarOf<S>;
    const auto z = static_cast<long double>(x);
    const Integrals here{z};
    const long double rise = z * z * (3 - 2 * z), tilt = z * z * (z - 1), rise_rate = 6 * z * (1 - z),
                      tilt_rate = z * (3 * z - 2);
    const auto scalar = [](long double weight) { return static_cast<Scalar>(weight); };
    const auto &r0 = position_of<S>(y0), &v0 = velocity_of<S>(y0), &r1 = position_of<S>(y1), &v1 = velocity_of<S>(y1);
    auto &r = position_of<S>(out), &v = velocity_of<S>(out);
    // (1) with δ_r, δ_v written out, sorted by r⁺ − r, v, v⁺ − v and k_j.
    r = r0 + scalar(rise) * (r1 - r0) + dt * (scalar(z - rise) * v0 + scalar(tilt) * (v1 - v0));
    v = v0 + scalar(tilt_rate) * (v1 - v0) + scalar(rise_rate) * ((r1 - r0) / dt - v0);
    for (std::size_t j = 0; j < nodes; ++j) {
      const auto& a = std::get<0>(Rate::blocks(k[static_cast<std::size_t>(Tableau::dense[j])]));
      r += dt * (dt * (scalar(here.twice[j] - rise * at_end.twice[j] - tilt * at_end.once[j]) * a));
      v += dt * (scalar(here.once[j] - rise_rate * at_end.twice[j] - tilt_rate * at_end.once[j]) * a);
    }
  }
};

}}  // namespace phistep::PHISTEP_ABI
