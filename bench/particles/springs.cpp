#include "springs.hpp"

#include <phistep/phistep.hpp>

#include <cstdio>
#include <stdexcept>

#include "rows.hpp"

namespace bench {
namespace {

auto network(const Sheet& sheet) {
  std::vector<phistep::Spring> springs;
  springs.reserve(sheet.springs());
  for (std::size_t s = 0; s < sheet.springs(); ++s)
    springs.push_back({sheet.ends[s].first, sheet.ends[s].second, Sheet::k, sheet.lengths[s]});
  return phistep::spring_network<3>(std::move(springs));
}

template <class State>
class Library : public SheetStepper {
 public:
  explicit Library(const Sheet& sheet)
      : state_{sheet.r, Eigen::Matrix3Xd::Zero(3, sheet.r.cols())},
        stepper_{state_, network(sheet), phistep::symplectic_euler} {}
  void step(int times) override {
    for (int n = 0; n < times; ++n)
      if (const auto report = stepper_.step(state_, Sheet::dt * done_++, Sheet::dt); !report)
        throw std::runtime_error(report.message());
  }
  [[nodiscard]] Eigen::Matrix3Xd positions() const override { return state_.r; }

 private:
  State state_;
  decltype(phistep::PhiStepper{std::declval<const State&>(), network(std::declval<const Sheet&>()),
                               phistep::symplectic_euler}) stepper_;
  int done_ = 0;
};
using Motion = phistep::Motion<Eigen::Matrix3Xd>;

const char* name_of(Order order) {
  switch (order) {
    case Order::sorted:
      return "sorted";
    case Order::springs_shuffled:
      return "springs shuffled";
    case Order::particles_shuffled:
      return "particles numbered anyhow";
  }
  return "";
}

/// Rounding: a spring's force of 1 … 10 is off by some 1e-15, moves its ends by Δt² of that, and Δt²k/m ≪ 1.
constexpr double tolerance = 1e-13;

}  // namespace

void springs(const Options& options, Table& table) {
  const int side = options.is_short ? 60 : 577, steps = 10;
  struct Runner {
    Order order;
    std::string name;
    std::unique_ptr<SheetStepper> stepper;
    int threads;
  };
  std::vector<Runner> runners;
  double work = 0;
  Eigen::Matrix3Xd right;
  const auto add = [&](const Sheet& sheet, Order order, const std::string& who, auto make, int threads) {
    auto stepper = make(sheet);
    use_threads(threads);
    stepper->step(steps);
    Eigen::Matrix3Xd found(3, sheet.r.cols());
    const Eigen::Matrix3Xd r = stepper->positions();
    for (Eigen::Index n = 0; n < r.cols(); ++n) found.col(n) = r.col(sheet.place[static_cast<std::size_t>(n)]);
    if (right.size() == 0) right = found;
    const double off = (found - right).cwiseAbs().maxCoeff();
    if (!(off <= tolerance)) throw std::runtime_error(who + ": positions are off by " + std::to_string(off));
    runners.push_back({order, who + ", " + name_of(order), std::move(stepper), threads});
  };
  for (const Order order : {Order::sorted, Order::springs_shuffled, Order::particles_shuffled}) {
    const Sheet sheet(side, order);
    work = static_cast<double>(sheet.springs()) * steps;
    add(sheet, order, "hand, spring by spring", hand_scatter, 1);
    add(sheet, order, "hand, particle by particle", hand_rows, 1);
    const auto library = [](const Sheet& s) { return std::make_unique<Library<Motion>>(s); };
    for (int threads = 1; threads <= options.threads; threads *= 2) add(sheet, order, "phistep", library, threads);
  }
  std::vector<Entrant> entrants;
  for (Runner& runner : runners)
    entrants.push_back({runner.name,
                        [&runner, steps] {
                          use_threads(runner.threads);
                          const Stopwatch watch(runner.threads);
                          runner.stepper->step(steps);
                          return watch.seconds();
                        },
                        runner.threads});
  take_turns(entrants, options.rounds);
  std::size_t best = 0;  // of the loops by hand on sorted springs: whatever order phistep is given, it sorts
  for (std::size_t e = 0; e < entrants.size(); ++e)
    if (runners[e].order == Order::sorted && runners[e].name.starts_with("hand") &&
        entrants[e].median() < entrants[best].median())
      best = e;
  table.rates("springs", right.cols(), work, "M springs/s", entrants, {entrants[best].name});
}

}  // namespace bench
