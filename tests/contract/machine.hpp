#pragma once

// Sequences of everything that a user may do to a stepper and a state, in any order: steps of any length and direction,
// steps that fail, edits, other sizes, checkpoints saved and loaded, resets. Beside the stepper under test go
//
//   a fresh one     made for each step, which knows nothing of what was before but the force's history
//   the other       made anew by a checkpoint now and then, that must stay equal to the bit, counts included
//   the spared one  which is not told of steps that fail

#include <phistep/io/checkpoint.hpp>
#include <phistep/phistep.hpp>

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "contract/property.hpp"
#include "contract/states.hpp"

namespace machine {

using namespace phistep;
using property::Source;
using Vec = Eigen::VectorXd;

/// What the force does at the call after so many more.
struct Mood {
  enum Kind { well, nan, infinite, exception } kind = well;
  int calls = 0;
  /// 0, or what ruins a force.
  double operator()() {
    if (kind == well || calls-- > 0) return 0;
    const Kind now = std::exchange(kind, well);
    if (now == exception) throw std::runtime_error("moody");
    return now == nan ? std::nan("") : HUGE_VAL;
  }
};
/// As a term: nothing but trouble.
struct Trouble : ForceTerm {
  Mood* mood;
  static constexpr bool uses_velocity = false, uses_time = false;
  static constexpr Structure structure = Structure::none;
  static constexpr bool is_affine = true, is_symmetric = true;
  explicit Trouble(Mood* m) : mood{m} {}
  void add(auto, const auto&, auto& out) const {
    const double ruin = (*mood)();
    if constexpr (requires { out.force; }) out.force.data()[0] += ruin;
    else out.rate.data()[0] += ruin;
  }
  static void add_jacobian(auto, const auto&, auto&) {}
};
/// A function that may fail; each of these signatures makes another kind of stepper.
template <class F>
struct Position {  // f(r), or f(y)
  F f;
  Mood* mood;
  Vec operator()(const Vec& r) const {
    Vec psi = f(r);
    if (psi.size() > 0) psi[psi.size() - 1] += (*mood)();
    return psi;
  }
};
template <class F>
struct Everything {  // f(r, v, t)
  F f;
  Mood* mood;
  Vec operator()(const Vec& r, const Vec& v, double t) const {
    Vec psi = f(r, v, t);
    if (psi.size() > 0) psi[psi.size() - 1] += (*mood)();
    return psi;
  }
};
template <class F>
struct Timed {  // f(y, t)
  F f;
  Mood* mood;
  Vec operator()(const Vec& y, double t) const {
    Vec psi = f(y, t);
    if (psi.size() > 0) psi[psi.size() - 1] += (*mood)();
    return psi;
  }
};

/// Something done to a state by its owner.
struct Edit {
  enum Kind { nothing, shift, flip, zero, swap, velocity, others } kind;
  int which, with;
  double value;
};

/// How a step ended: an outcome, or the force's exception.
using End = std::optional<Outcome>;

/// A stepper and its state.
class Pair {
 public:
  virtual ~Pair() = default;
  [[nodiscard]] virtual Vec numbers() const = 0;
  virtual void set(const Vec& numbers) = 0;
  /// False where properties were changed that belong to the state, beside its numbers.
  [[nodiscard]] virtual bool edit(const Edit& edit) = 0;
  [[nodiscard]] virtual bool resize(int n, const Edit& edit) = 0;
  [[nodiscard]] virtual End step(double t, double dt) = 0;
  /// What a stepper makes of the state that was made for this step.
  [[nodiscard]] virtual std::pair<End, Vec> fresh_step(double t, double dt) const = 0;
  [[nodiscard]] virtual std::string look() const = 0;  ///< what a checkpoint holds; nothing is forgotten
  virtual void save() = 0;
  virtual void load(const std::string& bytes) = 0;
  virtual void reset() = 0;
  [[nodiscard]] virtual Statistics statistics() const = 0;
  /// The program started again, for as large a state.
  [[nodiscard]] virtual std::unique_ptr<Pair> anew() const = 0;
};

/// `Case` says how: start(n) → State, stepper(state, mood), sizes.
template <class Case>
class PairOf : public Pair {
 public:
  using State = decltype(Case::start(1));
  using Stepper = decltype(Case::stepper(std::declval<const State&>(), nullptr));

  PairOf(int n, Mood* mood) : mood_{mood}, n_{n}, y_{Case::start(n)}, stepper_{Case::stepper(y_, mood)} {}

  [[nodiscard]] Vec numbers() const override { return flat(y_); }
  void set(const Vec& numbers) override {
    const double* from = numbers.data();
    for_each_block([&from](auto, auto& block) { from = copy(from, block.size(), block.data()); },
                   Blocks<State>::all(y_));
  }
  [[nodiscard]] bool edit(const Edit& edit) override {
    if constexpr (requires { Case::edit(y_, edit); })
      if (Case::edit(y_, edit)) return false;
    Vec x = numbers();
    if (x.size() == 0) return true;
    double& one = x[edit.which % x.size()];
    double& two = x[edit.with % x.size()];
    switch (edit.kind) {
      case Edit::nothing:
        break;
      case Edit::shift:
        one += edit.value;
        break;
      case Edit::flip:
        one = -one;
        break;
      case Edit::zero:
        one = 0;
        break;
      case Edit::swap:
        std::swap(one, two);
        break;
      case Edit::velocity:
        x.tail(x.size() / 2) *= edit.value;
        break;
      case Edit::others:
        x *= -0.5;
        break;
    }
    set(x);
    return true;
  }
  [[nodiscard]] bool resize(int n, const Edit& edit) override {
    n_ = n;
    if constexpr (requires { Case::resize(y_, n, edit); }) {
      Case::resize(y_, n, edit);
      return false;
    } else {
      y_ = Case::start(n);
      return true;
    }
  }
  [[nodiscard]] End step(double t, double dt) override {
    try {
      return stepper_.step(y_, t, dt).outcome();
    } catch (const std::runtime_error&) {
      return {};
    }
  }
  [[nodiscard]] std::pair<End, Vec> fresh_step(double t, double dt) const override {
    const Mood mood = std::exchange(*mood_, {});
    State y = y_;
    auto fresh = Case::stepper(y, mood_);
    if constexpr (Case::has_past) fresh.restore(stepper_.checkpoint());
    const End end = fresh.step(y, t, dt).outcome();
    *mood_ = mood;
    return {end, flat(y)};
  }
  [[nodiscard]] std::string look() const override {
    std::ostringstream out;
    detail::write_checkpoint(out, stepper_, y_);
    return out.str();
  }
  void save() override {
    std::ostringstream out;
    save_checkpoint(out, stepper_, y_);
  }
  void load(const std::string& bytes) override {
    std::istringstream in(bytes);
    load_checkpoint(in, stepper_, y_);
    if constexpr (requires { y_.body(); }) n_ = static_cast<int>(y_.size());
  }
  void reset() override { stepper_.reset(); }
  [[nodiscard]] Statistics statistics() const override { return stepper_.statistics(); }
  [[nodiscard]] std::unique_ptr<Pair> anew() const override { return std::make_unique<PairOf>(n_, mood_); }

 private:
  static const double* copy(const double* from, Eigen::Index n, double* to) {
    std::copy_n(from, n, to);
    return from + n;
  }
  [[nodiscard]] static Vec flat(const State& y) {
    std::vector<double> all;
    for_each_block(
        [&all](auto, const auto& block) { all.insert(all.end(), block.data(), block.data() + block.size()); },
        Blocks<State>::all(y));
    return Eigen::Map<const Vec>(all.data(), static_cast<Eigen::Index>(all.size()));
  }

  Mood* mood_;
  int n_;
  State y_;
  Stepper stepper_;
};

/// What is promised of a kind of stepper.
struct Promise {
  const char* name;
  bool exact;             ///< a fresh stepper gives the same bits: nothing is computed otherwise than by the formula
  bool forgetful;         ///< … and so does one that was spared the failures
  double tolerance;       ///< else: in units of round-off and of the state's largest number
  int smallest, largest;  ///< sizes
  std::function<std::unique_ptr<Pair>(int, Mood*)> make;
  bool forgets = true;       ///< after a failure, the next step has a fresh stepper's bits: it keeps no list of its own
  bool looks_ahead = false;  ///< its last force call of a step is the next one's first, and not looked at before then
};

/// One sequence.
inline void live(Source& source, const Promise& promise) {
  constexpr double u = std::numeric_limits<double>::epsilon() / 2;
  Mood mood;
  int n = source.integer("size", promise.smallest, promise.largest);
  const auto main = promise.make(n, &mood);
  auto other = promise.make(n, &mood), spared = promise.make(n, &mood);
  bool spared_is_equal = true;  // to the bit
  struct Saved {
    std::string bytes;
    double t;
    int n;
  };
  std::vector<Saved> saved;
  double t = 0, dt = 0.0625;
  // A stepper learns of another size at its next step: a checkpoint made before then fits no program.
  bool knows_size = true;
  // A program started again gives a state the properties that it had first: its stepper learns of others at its next
  // step, as of an edit. Same states to rounding, but not the same counts.
  bool has_first_properties = true;
  // After a failure or a reset the bits are a fresh stepper's, whatever the way to solve.
  bool is_as_new = true;

  const auto same = [](const Pair& a, const Pair& b) { return states::same_bits(a.numbers(), b.numbers()); };
  const auto near = [&](const Vec& a, const Vec& b, const char* what) {
    const double size = std::max(1.0, std::max(a.cwiseAbs().maxCoeff(), b.cwiseAbs().maxCoeff()));
    source.bound(states::distance(a, b), promise.tolerance * u * size, what);
  };
  const auto draw_edit = [&source] {
    Edit edit{};
    edit.kind = static_cast<Edit::Kind>(
        source.one_of("  edit", {"nothing", "shift", "flip", "zero", "swap", "velocity", "others"}));
    edit.which = source.integer("  which", 0, 11);
    edit.with = source.integer("  with", 0, 11);
    edit.value = source.real("  value", -0.5, 0.5);
    return edit;
  };
  const auto all = [&](auto&& act) {
    act(*main);
    act(*other);
    act(*spared);
  };
  /// Steps the twins: they end alike.
  const auto step_twins = [&](double by, const Mood& trouble) {
    knows_size = true;
    mood = trouble;
    const End end = main->step(t, by);
    mood = trouble;
    const End end_of_other = other->step(t, by);
    mood = {};
    source.require(end == end_of_other, "a stepper loaded from a checkpoint ends a step otherwise");
    source.require(same(*main, *other), "a stepper loaded from a checkpoint gives other bits");
    source.require(main->statistics() == other->statistics(), "a stepper loaded from a checkpoint counts otherwise");
    return end;
  };
  const auto compare_with_spared = [&](double by) {
    const End end = spared->step(t, by);
    source.require(end == Outcome::success, "a step succeeds only after failures");
    if (promise.forgetful || spared_is_equal) {
      source.require(same(*main, *spared), "failures before leave a trace in the bits");
    } else {
      near(main->numbers(), spared->numbers(), "failures before leave a trace");
      spared->set(main->numbers());
    }
  };
  /// A step, perhaps with trouble in it.
  const auto step = [&](double by, const Mood& trouble) {
    const Vec before = main->numbers();
    const auto [fresh_end, fresh] = main->fresh_step(t, by);
    const End end = step_twins(by, trouble);
    if (end != Outcome::success) {
      source.tell(std::string("  fails: ") + (end ? describe(*end) : "exception"));
      source.require(states::same_bits(main->numbers(), before), "a step that fails changes the state");
      if (trouble.kind == Mood::well) source.require(fresh_end == end, "fails where a fresh stepper doesn't");
      spared_is_equal = false;
      is_as_new = true;
      return;
    }
    source.require(fresh_end == end, "succeeds where a fresh stepper fails");
    if (promise.exact || (promise.forgets && is_as_new && trouble.kind == Mood::well))
      source.require(states::same_bits(main->numbers(), fresh), "other bits than a fresh stepper's");
    else near(main->numbers(), fresh, "differs from a fresh stepper's");
    is_as_new = false;
    if (trouble.kind != Mood::well) spared_is_equal = false;  // a fault inside of a step may have been overcome
    compare_with_spared(by);
    t += by;
    // A force that was ill at the step's end, once, where it was asked for the next step's sake: that step will tell.
    if (trouble.kind != Mood::well && promise.looks_ahead) all([](Pair& pair) { pair.reset(); });
    if (main->numbers().size() > 0 && !(main->numbers().cwiseAbs().maxCoeff() <= 3)) {
      const Vec calm = main->numbers().cwiseMax(-1).cwiseMin(1);
      all([&](Pair& pair) { pair.set(calm); });
    }
  };

  while (source.more(12)) {
    switch (source.one_of("then", {"step", "of another length", "backward", "edit", "a failure", "an impossible step",
                                   "restarted", "save", "load", "resize", "reset", "another time", "much too far"})) {
      case 0:
        step(dt, {});
        break;
      case 1:
        dt = source.real("  dt", 0.0078125, 0.125);
        step(dt, {});
        break;
      case 2:
        step(-0.03125, {});
        break;
      case 3: {
        const Edit edit = draw_edit();
        all([&](Pair& pair) { has_first_properties = pair.edit(edit) && has_first_properties; });
        break;
      }
      case 4: {
        Mood trouble;
        trouble.kind = static_cast<Mood::Kind>(1 + source.one_of("  which", {"NaN", "infinite", "exception"}));
        trouble.calls = source.integer("  after calls", 0, 12);
        step(dt, trouble);
        break;
      }
      case 5: {
        const double bad[] = {0, std::nan(""), HUGE_VAL, -HUGE_VAL, 1e-300};
        const double by = bad[source.below(5)];
        const Vec before = main->numbers();
        if (!knows_size) spared_is_equal = false;  // a try is enough to learn of another size
        const End end = step_twins(t == 0 && by == 1e-300 ? 0 : by, {});
        source.require(end != Outcome::success, "an impossible step succeeds");
        source.require(states::same_bits(main->numbers(), before), "an impossible step changes the state");
        break;
      }
      case 6: {
        if (!has_first_properties) break;
        all([](Pair& pair) { pair.save(); });  // each forgets what is not in there
        const std::string bytes = main->look();
        auto fresh = main->anew();
        try {
          fresh->load(bytes);
        } catch (const CheckpointError&) {
          source.require(!knows_size, "a checkpoint is refused");
          break;
        }
        other = std::move(fresh);
        source.require(other->look() == bytes, "what was loaded is saved as other bytes");
        break;
      }
      case 7:
        all([](Pair& pair) { pair.save(); });
        if (knows_size && has_first_properties)
          saved.push_back({main->look(), t, static_cast<int>(main->numbers().size())});
        break;
      case 8: {
        if (saved.empty() || !has_first_properties) break;
        const Saved& from = saved[source.below(saved.size())];
        const std::string before = main->look();
        try {
          main->load(from.bytes);
        } catch (const CheckpointError&) {
          source.require(from.n != static_cast<int>(main->numbers().size()) || !knows_size,
                         "its own checkpoint is refused");
          source.require(main->look() == before, "a checkpoint refused changes something");
          break;
        }
        source.require(main->look() == from.bytes, "what was loaded is saved as other bytes");
        other->load(from.bytes);
        spared = main->anew();
        spared->load(from.bytes);
        spared_is_equal = true;
        is_as_new = false;
        t = from.t;
        break;
      }
      case 9: {
        n = source.integer("  size", promise.smallest, promise.largest);
        const Edit edit = draw_edit();
        all([&](Pair& pair) { has_first_properties = pair.resize(n, edit) && has_first_properties; });
        knows_size = false;
        break;
      }
      case 10:
        all([](Pair& pair) { pair.reset(); });
        spared_is_equal = true;
        is_as_new = true;
        break;
      case 11:
        t = source.number("  t", 4);
        break;
      case 12: {
        if (!promise.exact) break;  // implicit equations so far from their guess end by luck
        const Vec before = main->numbers();
        const auto [fresh_end, fresh] = main->fresh_step(t, 1e200);
        const End end = step_twins(1e200, {});
        source.require(fresh_end == end, "a fresh stepper ends a step too far otherwise");
        if (end != Outcome::success) {
          source.require(states::same_bits(main->numbers(), before), "a step too far changes the state");
          spared_is_equal = false;
          break;
        }
        source.require(spared->step(t, 1e200) == end, "a step too far succeeds only after failures");
        all([&](Pair& pair) { pair.set(before); });
        break;
      }
    }
  }
  // All that later steps depend on is equal, too.
  source.require(main->look() == other->look(), "a stepper loaded from a checkpoint saves other bytes");
}

template <class Case>
[[nodiscard]] Promise promise(const char* name, bool exact, bool forgetful, double tolerance, int smallest,
                              int largest) {
  return {name, exact, forgetful, tolerance, smallest, largest, [](int n, Mood* mood) -> std::unique_ptr<Pair> {
            return std::make_unique<PairOf<Case>>(n, mood);
          }};
}

}  // namespace machine
