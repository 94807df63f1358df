#pragma once

// Runs that are starved of memory: every allocation of a whole run fails once, from the construction of state, stepper and
// run through its steps, observers and checkpoints. What is thrown is std::bad_alloc, no step is half done, nothing leaks,
// and with memory back the run goes on.

#include "failure/heap.hpp"
//
#include "failure/faults.hpp"

namespace hunger {

using namespace faults;

/// The end of the program's appetite: what `act` did.
enum class Act { done, starved, other };
[[nodiscard]] inline Act fed(auto&& act) {
  try {
    const heap::Armed armed;
    act();
    return Act::done;
  } catch (const std::bad_alloc&) {
    return Act::starved;
  } catch (...) {
    return Act::other;
  }
}

/// One life of a run, its `fatal`-th allocation failing. Returns how many there were.
inline std::int64_t live_once(const Make& make, const Trajectory& good, std::int64_t fatal, bool lasting,
                              const Promise& promise, Tally& tally, const std::string& label) {
  const std::string what = label + ": allocation " + std::to_string(fatal) + (lasting ? " and after" : "");
  ++tally.runs;
  const std::int64_t before = heap::live, failures = heap::failed;
  std::int64_t allocations = 0;
  {
    heap::count = 0, heap::fatal = fatal, heap::lasting = lasting;
    std::unique_ptr<Machine> machine;
    const auto cure = [&] { heap::fatal = -1; };
    while (!machine) {
      const Act act = fed([&] { machine = make(); });
      if (act == Act::other) tally.blame(tally.untold, what + " at construction: not std::bad_alloc");
      if (act != Act::done) cure();
    }
    std::size_t n = 0;
    std::string last = machine->bits();
    double t = machine->time();
    long calls = 0;
    bool more = true;
    while (more) {
      if (++calls > 100000) {
        tally.blame(tally.stuck, what + ": never ends");
        break;
      }
      const Act act = fed([&] { more = machine->advance(); });
      const std::string now = machine->bits();
      if (act == Act::other) tally.blame(tally.untold, what + " in a step: not std::bad_alloc");
      if (act != Act::done) {
        ++tally.failures;
        const bool stands = now == last && machine->time() == t;
        const bool went = promise.moves_on && n + 1 < good.bits.size() && now == good.bits[n + 1] &&
                          machine->time() == good.times[n + 1];
        if (!stands && !went) tally.blame(tally.changed, what + ": changes the state");
        n += went;
        last = now, t = machine->time();
        cure();
        continue;
      }
      if (!more && machine->report().outcome != Outcome::success) {
        // A solver that reports its hunger as a failure.
        ++tally.failures;
        if (now != last || machine->time() != t) tally.blame(tally.changed, what + ": changes the state");
        if (heap::fatal < 0) {
          tally.blame(tally.stuck, what + ": " + machine->report().message());
          break;
        }
        cure();
        machine->renew();
        more = true;
        continue;
      }
      if (!more) break;
      ++n, last = now, t = machine->time();
      // A checkpoint now and then, and back.
      if (n % 2 == 1 && !good.checkpoints.empty()) {
        std::string bytes;
        if (fed([&] { bytes = machine->save(); }) != Act::done) {
          ++tally.failures;
          cure();
          if (machine->bits() != last || machine->time() != t) tally.blame(tally.changed, what + ": save changes it");
          bytes = machine->save();
        }
        const std::string whole = machine->look();
        if (whole != bytes) tally.blame(tally.otherwise, what + ": saves something else");
        // Loading the past fails, or succeeds: nothing in between.
        const std::string& past = good.checkpoints[n - 1];
        const Act loaded = fed([&] { machine->load(past); });
        if (loaded == Act::other) tally.blame(tally.untold, what + " while loading: not std::bad_alloc");
        const std::string is = machine->look();
        if (loaded != Act::done) {
          ++tally.failures;
          cure();
          if (is != whole) tally.blame(tally.changed, what + ": half a checkpoint is loaded");
        }
        machine->load(bytes);
        if (machine->look() != bytes) tally.blame(tally.otherwise, what + ": loads something else");
        if (machine->bits() != last) tally.blame(tally.changed, what + ": a checkpoint changes the state");
      }
    }
    allocations = heap::count;
    cure();
    if (machine->time() != good.times.back()) tally.blame(tally.stuck, what + ": does not reach its end");
    const double off = gap(machine->numbers(), good.end);
    if (promise.same_end > 0) tally.farthest = std::max(tally.farthest, off);
    if (promise.same_end > 0 ? !(off <= promise.same_end) : machine->bits() != good.bits.back())
      tally.blame(tally.otherwise, what + ": ends elsewhere, by " + std::to_string(off * 1e12) + "e-12");
  }
  if (heap::live != before && !promise.leaks)
    tally.blame(tally.otherwise, what + ": leaks " + std::to_string(heap::live - before));
  if (fatal >= 0 && heap::failed == failures) --tally.runs;  // there was no such allocation any more
  return allocations;
}

/// Every allocation of a run's life.
[[nodiscard]] inline Tally every_allocation(const std::string& label, const Make& make, const Promise& promise,
                                            bool with_checkpoints = true, std::int64_t stride = 1) {
  Tally tally;
  const Trajectory good = unbroken(make, with_checkpoints);
  static_cast<void>(live_once(make, good, -1, false, promise, tally, label));  // what is made once a program
  const std::int64_t all = live_once(make, good, -1, false, promise, tally, label);
  for (std::int64_t k = 0; k < all; k += stride)
    for (const bool lasting : {false, true})
      static_cast<void>(live_once(make, good, k, lasting, promise, tally, label));
  return tally;
}

}  // namespace hunger
