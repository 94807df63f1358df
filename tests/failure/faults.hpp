#pragma once

// Failure injection: a run is done once unbroken, then once for every k with something failing at its k-th call. After
// each failure the state must be that of the last step accepted, the outcome must say what and where, and the run must go
// on from there.

#include <phistep/io/checkpoint.hpp>
#include <phistep/phistep.hpp>

#include <cmath>
#include <cstddef>
#include <cstring>
#include <functional>
#include <iostream>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "contract/states.hpp"
#include "support/catch.hpp"

namespace faults {

using namespace phistep;

/// Who fails, and how.
enum class Site { force, jacobian, solver, observer, event, handler, count };
enum class Kind { nan, inf, exception, size, refuses };

inline const char* name(Site site) {
  constexpr const char* names[] = {"force", "Jacobian", "solver", "observer", "event", "handler"};
  return names[static_cast<std::size_t>(site)];
}
inline const char* name(Kind kind) {
  constexpr const char* names[] = {"NaN", "infinity", "exception", "wrong size", "refusal"};
  return names[static_cast<std::size_t>(kind)];
}

/// What a failing call throws.
struct Struck : std::runtime_error {
  Struck() : std::runtime_error("struck") {}
};

/// The one fault of this program: strikes at the `at`-th call of `site`, and with `lasting` ever after.
struct Fault {
  Site site = Site::force;
  Kind kind = Kind::exception;
  long at = -1;
  bool lasting = false;
  long calls[static_cast<std::size_t>(Site::count)] = {};
  long hits = 0;

  [[nodiscard]] bool strikes(Site here) {
    const long call = calls[static_cast<std::size_t>(here)]++;
    if (at < 0 || here != site || (lasting ? call < at : call != at)) return false;
    ++hits;
    if (kind == Kind::exception) throw Struck();
    return true;
  }
  [[nodiscard]] double bad() const { return kind == Kind::inf ? HUGE_VAL : std::nan(""); }
  void cure() { at = -1; }
};
inline Fault fault;

/// Passes numbers on, or spoils one of them.
template <class V>
[[nodiscard]] V struck(Site here, V f) {
  if (fault.strikes(here)) {
    if constexpr (V::SizeAtCompileTime == Eigen::Dynamic) {
      if (fault.kind == Kind::size)
        return V::Zero(V::RowsAtCompileTime == Eigen::Dynamic ? f.rows() + 1 : f.rows(),
                       V::RowsAtCompileTime == Eigen::Dynamic ? f.cols() : f.cols() + 1);
    }
    f.data()[f.size() - 1] = fault.bad();
  }
  return f;
}

/// A run as the driver sees it.
class Machine {
 public:
  virtual ~Machine() = default;
  virtual bool advance() = 0;
  [[nodiscard]] virtual double time() const = 0;
  /// State and history of the force, every bit.
  [[nodiscard]] virtual std::string bits() const = 0;
  [[nodiscard]] virtual Eigen::VectorXd numbers() const = 0;
  [[nodiscard]] virtual bool has_ended() const = 0;
  [[nodiscard]] virtual RunReport report() const = 0;
  /// A new run from where this one stands to its end, with the same stepper.
  virtual void renew() = 0;
  /// The same with a new stepper that has the same history, for a state of its own; null where there is no such stepper.
  [[nodiscard]] virtual std::unique_ptr<Machine> fresh() const = 0;
  [[nodiscard]] virtual std::string look() const = 0;  ///< what save() would write; nothing is forgotten
  virtual std::string save() = 0;
  virtual void load(const std::string& bytes) = 0;
};

template <class... Parts>
[[nodiscard]] std::string bytes_of(const Parts&... parts) {
  Writer writer;
  writer.save(parts...);
  return {reinterpret_cast<const char*>(writer.bytes().data()), writer.bytes().size()};
}

/// @tparam Observers  makes a tuple of them, to be kept with the run
template <class S, class Stepper, class Control, class Observers>
class MachineOf final : public Machine {
  using Tuple = std::invoke_result_t<Observers&>;
  template <class... O>
  static std::type_identity<Run<Stepper, S, Control, O&...>> run_type(std::tuple<O...>&);
  using RunType = typename decltype(run_type(std::declval<Tuple&>()))::type;

 public:
  MachineOf(S start, const std::function<Stepper(S&)>& make, double t1, Control control, Observers observers)
      : MachineOf{std::move(start), make, 0, t1, control, observers} {}
  MachineOf(S start, const std::function<Stepper(S&)>& make, double t, double t1, Control control, Observers observers)
      : make_{make},
        make_observers_{observers},
        y_{std::move(start)},
        stepper_{make(y_)},
        t1_{t1},
        control_{control},
        observers_{observers()} {
    begin(t);
  }
  bool advance() override { return run_->advance(); }
  double time() const override { return run_->time(); }
  std::string bits() const override {
    if constexpr (requires { stepper_.memory(); }) return bytes_of(y_, stepper_.memory());
    else if constexpr (requires { stepper_.stepper().memory(); }) return bytes_of(y_, stepper_.stepper().memory());
    else return bytes_of(y_);
  }
  Eigen::VectorXd numbers() const override { return states::numbers(y_); }
  bool has_ended() const override { return run_->has_ended(); }
  RunReport report() const override { return run_->report(); }
  void renew() override { begin(run_->time()); }
  std::unique_ptr<Machine> fresh() const override {
    if constexpr (requires(Stepper & stepper) { stepper.restore(stepper.checkpoint()); }) {
      auto other = std::make_unique<MachineOf>(y_, make_, run_->time(), t1_, control_, make_observers_);
      other->stepper_.restore(stepper_.checkpoint());
      return other;
    } else {
      return nullptr;
    }
  }
  std::string look() const override {
    std::ostringstream out;
    detail::write_checkpoint(out, *run_);
    return out.str();
  }
  std::string save() override {
    std::ostringstream out;
    save_checkpoint(out, *run_);
    return out.str();
  }
  void load(const std::string& bytes) override {
    std::istringstream in(bytes);
    load_checkpoint(in, *run_);
  }

 private:
  void begin(double t) {
    std::apply(
        [&](auto&... observer) {
          run_.reset();
          run_ = std::unique_ptr<RunType>(new RunType(stepper_, y_, {t, t1_}, control_, observer...));
        },
        observers_);
  }

  std::function<Stepper(S&)> make_;
  Observers make_observers_;
  S y_;
  Stepper stepper_;
  double t1_;
  Control control_;
  Tuple observers_;
  std::unique_ptr<RunType> run_;
};

inline constexpr auto nobody = [] { return std::tuple<>{}; };

using Make = std::function<std::unique_ptr<Machine>()>;

/// Makes the same run again and again. `stepper(y)` makes the stepper for a state.
template <class Start, class Stepper, class Control, class Observers = decltype(nobody)>
[[nodiscard]] Make machine(Start start, Stepper stepper, double t1, Control control, Observers observers = nobody) {
  using S = std::invoke_result_t<Start>;
  using Its = std::invoke_result_t<Stepper, S&>;
  return [=]() -> std::unique_ptr<Machine> {
    return std::make_unique<MachineOf<S, Its, Control, Observers>>(start(), stepper, t1, control, observers);
  };
}

/// What is promised of a scenario.
struct Promise {
  double same_end = 0;     ///< the end of a run that goes on and the unbroken one's differ by no more; 0: not by a bit
  double renewed = 0;      ///< … of a new run from where that one failed, or of one that found a way around the fault
  bool moves_on = false;   ///< who fails is called after the step: the step stands
  bool in_solver = false;  ///< a linear solver asks the force, and is then what fails
  bool forgets = true;     ///< a run that goes on from a failure by a new one goes on as with a new stepper, to the bit
  bool leaks = false;      ///< Eigen 3.4 does, where memory ends while it copies a sparse matrix
};

/// Counts of what went wrong, and of what was tried.
struct Tally {
  long runs = 0, failures = 0, survived = 0;
  long changed = 0;     ///< the state was not that of the last accepted step
  long untold = 0;      ///< an outcome of another kind, or a message without t, dt or advice
  long stuck = 0;       ///< the run could not go on
  long otherwise = 0;   ///< it went on to another end
  double farthest = 0;  ///< distance of the ends where bits are not promised
  std::string first;    ///< the first thing that went wrong

  void blame(long& count, const std::string& what) {
    if (++count == 1 && first.empty()) first = what;
  }
  [[nodiscard]] bool clean() const { return changed + untold + stuck + otherwise == 0; }
  Tally& operator+=(const Tally& other) {
    runs += other.runs, failures += other.failures, survived += other.survived;
    changed += other.changed, untold += other.untold, stuck += other.stuck, otherwise += other.otherwise;
    farthest = std::max(farthest, other.farthest);
    if (first.empty()) first = other.first;
    return *this;
  }
};

/// The states of the unbroken run.
struct Trajectory {
  std::vector<std::string> bits;
  std::vector<double> times;
  std::vector<std::string> checkpoints;
  Eigen::VectorXd end;
  Fault counted;  ///< calls of a whole run
};
[[nodiscard]] inline Trajectory unbroken(const Make& make, bool with_checkpoints = false) {
  fault = {};
  Trajectory all;
  const auto machine = make();
  const auto note = [&] {
    all.bits.push_back(machine->bits());
    all.times.push_back(machine->time());
    // Saving forgets Jacobians: done where the runs that are compared with this one do it.
    if (with_checkpoints) all.checkpoints.push_back(all.times.size() % 2 == 0 ? machine->save() : machine->look());
  };
  note();
  while (machine->advance()) note();
  REQUIRE(machine->report());
  all.bits.back() = machine->bits();  // the last call may have told an event's handler alone
  all.end = machine->numbers();
  all.counted = fault;
  return all;
}

[[nodiscard]] inline bool is_told(const RunReport& report, Site site, Kind how, const Promise& promise) {
  const Outcome outcome = report.outcome;
  const std::string message = report.message();
  const bool in_a_step = report.failure.outcome == outcome;
  const bool kind = [&] {
    if (how == Kind::size) return outcome == Outcome::wrong_size;
    switch (site) {
      case Site::force:
        return outcome == Outcome::non_finite_force || outcome == Outcome::non_finite_jacobian ||
               (promise.in_solver && outcome == Outcome::linear_solver_failed);
      case Site::jacobian:
        return outcome == Outcome::non_finite_jacobian;
      case Site::solver:
        return outcome == Outcome::singular_matrix || outcome == Outcome::not_positive_definite ||
               outcome == Outcome::linear_solver_failed || outcome == Outcome::non_finite_state;
      case Site::event:
        return outcome == Outcome::non_finite_event;
      default:
        return false;
    }
  }();
  const auto has = [&](const char* what) { return message.find(what) != std::string::npos; };
  return kind && has(describe(outcome)) && has(advise(outcome)) && has("t = ") && (!in_a_step || has("dt = "));
}

[[nodiscard]] inline double gap(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  const double scale = std::max(1.0, b.cwiseAbs().maxCoeff());
  return states::distance(a, b) / scale;
}

/// One run with one fault.
inline void strike(const Make& make, const Trajectory& good, Site site, Kind kind, long k, bool lasting,
                   const Promise& promise, Tally& tally, const std::string& label) {
  fault = {};
  fault.site = site, fault.kind = kind, fault.at = k, fault.lasting = lasting;
  const std::string what =
      label + ": " + name(site) + ", " + name(kind) + " at call " + std::to_string(k) + (lasting ? " and after" : "");
  ++tally.runs;
  const auto machine = make();
  std::size_t n = 0;  // steps done
  std::string last = machine->bits();
  double t = machine->time();
  bool failed = false, around = false, renewed = false;
  std::unique_ptr<Machine> fresh;  // from the last failure
  const auto renew = [&] {
    renewed = true;
    if (promise.forgets) fresh = machine->fresh();
    machine->renew();
  };
  for (long calls = 0;; ++calls) {
    if (calls > 100000) return tally.blame(tally.stuck, what + ": never ends");
    const long hits = fault.hits;
    bool more = false;
    try {
      more = machine->advance();
    } catch (const std::exception& error) {
      if (dynamic_cast<const Struck*>(&error) == nullptr) tally.blame(tally.untold, what + ": throws " + error.what());
      failed = true;
      ++tally.failures;
      const std::string now = machine->bits();
      const bool stands = now == last && machine->time() == t;
      // Who looks at a step after it was done can't undo it.
      const bool went = promise.moves_on && n + 1 < good.bits.size() && now == good.bits[n + 1] &&
                        machine->time() == good.times[n + 1];
      if (!stands && !went) tally.blame(tally.changed, what + ": changes the state");
      if (went) ++n;
      last = now, t = machine->time();
      fault.cure();
      fresh = nullptr;
      if (machine->has_ended()) renew();
      continue;
    }
    if (!more && machine->report().outcome != Outcome::success) {
      failed = true;
      ++tally.failures;
      const RunReport report = machine->report();
      if (!is_told(report, site, kind, promise)) tally.blame(tally.untold, what + ": " + report.message());
      const std::string now = machine->bits();
      const bool stands = now == last && machine->time() == t;
      // A new run doesn't know that it starts where an event has just happened: that one may happen again.
      if (!stands && promise.moves_on && n + 1 < good.bits.size() && now == good.bits[n + 1] &&
          machine->time() == good.times[n + 1])
        return;
      if (!stands) tally.blame(tally.changed, what + ": changes the state");
      if (fault.at < 0) return tally.blame(tally.stuck, what + ": " + report.message());
      fault.cure();
      renew();
      continue;
    }
    if (fault.hits > hits) around = true, ++tally.survived;
    if (!more) break;
    last = machine->bits(), t = machine->time(), ++n;
    if (!failed && !around && n < good.bits.size() && last != good.bits[n])
      tally.blame(tally.changed, what + ": another run before the fault");
  }
  if (fresh) {
    const long at = std::exchange(fault.at, -1);
    while (fresh->advance()) {
    }
    fault.at = at;
    if (fresh->bits() != machine->bits()) tally.blame(tally.otherwise, what + ": a new stepper ends with other bits");
  }
  if (machine->time() != good.times.back()) return tally.blame(tally.stuck, what + ": does not reach its end");
  const double allowed = around || renewed ? std::max(promise.renewed, promise.same_end) : promise.same_end;
  const double off = gap(machine->numbers(), good.end);
  if (allowed > 0) tally.farthest = std::max(tally.farthest, off);
  if (allowed > 0 ? !(off <= allowed) : machine->bits() != good.bits.back())
    tally.blame(tally.otherwise, what + ": ends elsewhere, by " + std::to_string(off * 1e12) + "e-12");
}

/// Every call of a site, every kind, passing and lasting.
[[nodiscard]] inline Tally every_call(const std::string& label, const Make& make, Site site,
                                      const std::vector<Kind>& kinds, const Promise& promise, long stride = 1) {
  Tally tally;
  const Trajectory good = unbroken(make);
  const long calls = good.counted.calls[static_cast<std::size_t>(site)];
  if (calls == 0) tally.blame(tally.stuck, label + ": " + name(site) + " is never called");
  for (long k = 0; k < calls; k += stride)
    for (const Kind kind : kinds)
      for (const bool lasting : {false, true})
        if (!lasting || kind != Kind::size) strike(make, good, site, kind, k, lasting, promise, tally, label);
  return tally;
}

}  // namespace faults
