// Checkpoints that somebody has changed, with a checksum that fits: refused with nothing changed, or loaded and gone on
// with. The bytes say which program, after how many steps, and what is done to what it wrote.
#include <phistep/io/checkpoint.hpp>
#include <phistep/particles.hpp>
#include <phistep/phistep.hpp>

#include <cstring>
#include <memory>
#include <sstream>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "fuzz/fuzz.hpp"

using namespace phistep;
using fuzz::Bytes;
using fuzz::demand;
using Vec = Eigen::VectorXd;

namespace {

template <class... Parts>
std::string bytes_of(const Parts&... parts) {
  std::ostringstream out;
  detail::write_checkpoint(out, parts...);
  return out.str();
}
template <class... Parts>
void load_bytes(const std::string& bytes, Parts&... parts) {
  std::istringstream in(bytes);
  load_checkpoint(in, parts...);
}

struct Decay {
  Vec operator()(const Vec& y, double t) const {
    return -2 * y - y.cwiseProduct(y) + Vec::Constant(y.size(), std::sin(t));
  }
};
struct Swing {
  Vec operator()(const Vec& r, const Vec& v) const { return -r.array().sin().matrix() - 0.1 * v; }
};

/// A stepper, its state and its time.
template <class State, class Stepper>
struct Steps {
  State y;
  Stepper stepper;
  double t = 0, dt;
  Steps(const State& start, Stepper s, double step) : y{start}, stepper{std::move(s)}, dt{step} {}
  [[nodiscard]] std::string bytes() const { return bytes_of(stepper, y, t); }
  void load(const std::string& from) { load_bytes(from, stepper, y, t); }
  void advance() {
    const StepReport report = stepper.step(y, t, dt);
    if (report) t += dt;
    else demand(!report.message().empty(), "a failure has its message");
  }
};
template <class State, class Make>
auto steps(const State& start, double dt, Make make) {
  return std::make_unique<Steps<State, decltype(make(start))>>(start, make(start), dt);
}

/// A run with observers that remember.
template <class State, class Stepper, class Control>
struct Controlled {
  State y;
  Stepper stepper;
  Recorder<State> recorder;
  Run<Stepper, State, Control, Recorder<State>&> run;
  Controlled(const State& start, Stepper s, const Control& control)
      : y{start}, stepper{std::move(s)}, run{stepper, y, {0.0, 3.0}, control, recorder} {}
  Controlled(const Controlled&) = delete;
  [[nodiscard]] std::string bytes() const { return bytes_of(run); }
  void load(const std::string& from) { load_bytes(from, run); }
  void advance() {
    if (run.advance()) return;
    std::ostringstream out;
    out << run.report();
    demand(!out.str().empty(), "a run has its report");
  }
};
template <class State, class Control, class Make>
auto controlled(const State& start, const Control& control, Make make) {
  return std::make_unique<Controlled<State, decltype(make(start)), Control>>(start, make(start), control);
}
struct Watched {  // events and samples
  using State = Motion<Vec>;
  struct Height {
    double operator()(const State& at) const { return at.r[0] - 0.2; }
  };
  struct Nothing {
    void operator()(double, const State&) const {}
  };
  State y;
  decltype(PhiStepper{State{}, Swing{}, velocity_verlet}) stepper;
  decltype(event(Height{}, EventOptions{}, Nothing{})) crossing;
  decltype(sampled(0.1, Nothing{})) samples;
  Run<decltype(stepper), State, FixedStep, decltype(crossing)&, decltype(samples)&> run;
  explicit Watched(const State& start)
      : y{start},
        stepper{PhiStepper{y, Swing{}, velocity_verlet}},
        crossing{event(Height{}, EventOptions{}, Nothing{})},
        samples{sampled(0.1, Nothing{})},
        run{stepper, y, {0.0, 3.0}, fixed(0.25), crossing, samples} {}
  Watched(const Watched&) = delete;
  [[nodiscard]] std::string bytes() const { return bytes_of(run); }
  void load(const std::string& from) { load_bytes(from, run); }
  void advance() { static_cast<void>(run.advance()); }
};

/// Whatever can be archived.
struct Values {
  std::vector<std::vector<double>> nested{{1, 2}, {}, {3}};
  std::vector<std::string> words{"one", "", "three"};
  std::vector<bool> flags{true, false};
  std::pair<int, std::string> maybe{1, "x"};
  std::tuple<Eigen::MatrixXd, Eigen::Matrix3Xf, Eigen::Vector2d> matrices{
      Eigen::MatrixXd::Ones(2, 3), Eigen::Matrix3Xf::Ones(3, 2), {1, 2}};
  std::array<long double, 2> wide{1, 2};
  Particles<double, 2> atoms{Eigen::Matrix2Xd::Identity(2, 2)};
  Recorder<Vec> recorder;
  int seen = 0;
  [[nodiscard]] std::string bytes() const {
    return bytes_of(nested, words, maybe, matrices, wide, atoms, recorder, seen);
  }
  void load(const std::string& from) {
    load_bytes(from, nested, words, maybe, matrices, wide, atoms, recorder, seen);
    demand(atoms.r.cols() == atoms.size() && atoms.mass().size() == atoms.size(), "particles fit together");
  }
  void advance() {
    ++seen;
    recorder(seen, Vec::Constant(3, seen));
    if (atoms.size() < 100) atoms.add(Particles<double, 2>{atoms});
    words.emplace_back("more"), nested.push_back({0.5});
    demand(recorder.states().cols() == recorder.size() && recorder.block(0).cols() == recorder.size(), "columns");
  }
};

Particles<double, 3, Spin> grains() {
  Eigen::Matrix3Xd r(3, 4), v(3, 4);
  r << 0, 0.95, 2, 0.4, 0, 0, 0, 0.1, 0.48, 0.48, 0.49, 1.4;
  v << 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, -1;
  Particles<double, 3, Spin> all{r, v};
  return all.set_radius(0.5).set_box({{0, 0, 0}, {6, 6, 6}, {true, true, false}});
}
Particles<double, 3> gas() {
  Eigen::Matrix3Xd r(3, 5);
  r << 0, 1.1, 0, 0, 2.4, 0, 0, 1.2, 0, 0.1, 0, 0, 0, 1.1, 2.5;
  Particles<double, 3> atoms{r};
  return atoms.set_box(Box<double, 3>::periodic({0, 0, 0}, {4, 4, 4}));
}

constexpr int programs = 9;
/// f(a program that hasn't begun)
void with_program(int which, auto&& f) {
  const Vec y = Vec::LinSpaced(3, 1, 2);
  const Motion<Vec> swing{y, Vec::Zero(3)};
  const Hooke law{.stiffness = 1e4, .restitution = 0.2, .friction = 0.4, .rolling_friction = 0.1};
  switch (which) {
    case 0:
      return f(std::make_unique<Values>());
    case 1:
      return f(steps(y, 0.1, [](const Vec& x) { return PhiStepper{x, Decay{}, tr_bdf2}; }));
    case 2:
      return f(std::make_unique<Watched>(swing));
    case 3:
      return f(controlled(swing, tolerance{}, [](const auto& x) { return PhiStepper{x, Swing{}, trapezoidal}; }));
    case 4:
      return f(controlled(y, tolerance{}, [](const Vec& x) { return PhiStepper{x, Decay{}, radau}; }));
    case 5:
      return f(controlled(y, tolerance{}, [](const Vec& x) { return PhiStepper{x, Decay{}, tsit5}; }));
    case 6:
      return f(steps(grains(), 1e-3, [&law](const auto& x) {
        const auto force = Contact{law} +
                           Walls<Hooke>{law, Plane<3>{Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ()}} +
                           Gravity{Eigen::Vector3d{0, 0, -9}};
        return Sleeping{PhiStepper{x, force, symplectic_euler}, SleepOptions{.speed = 0.02, .steps = 4, .every = 2}};
      }));
    case 7:
      return f(steps(gas(), 1e-2, [](const auto& x) {
        return PhiStepper{x, Pairs{LennardJones{}, 1.8}, trapezoidal};
      }));
    default:
      return f(steps(y, 0.1, [](const Vec& x) { return Halving{PhiStepper{x, Decay{}, rodas4}, 3}; }));
  }
}

/// Overwrites, moves, removes or inserts.
void edit(std::string& text, std::size_t first, Bytes& by) {
  if (text.size() <= first) return;
  const int kind = by.byte() % 8;
  const std::size_t room = text.size() - first, at = first + by.word() % 65536 % room, n = 1 + by.byte() % 16u;
  const auto put = [&](std::uint64_t x) {
    std::memcpy(text.data() + at, &x, std::min<std::size_t>(8, text.size() - at));
  };
  switch (kind) {
    case 0:
      text[at] = static_cast<char>(by.byte());
      break;
    case 1: {
      constexpr std::uint64_t top = std::uint64_t{1} << 63;
      constexpr std::array special{
          std::uint64_t{0},       std::uint64_t{1},       ~std::uint64_t{0},     top, top - 1, top >> 1, top >> 3,
          std::uint64_t{1} << 32, std::uint64_t{1} << 31, std::uint64_t{1} << 20};
      put(special[by.byte() % special.size()]);
      break;
    }
    case 2:
      put(std::bit_cast<std::uint64_t>(by.wild()));
      break;
    case 3:
      put(by.word());
      break;
    case 4:
      put(static_cast<std::uint64_t>(static_cast<std::int8_t>(by.byte())));
      break;
    case 5:
      text.erase(at, n);
      break;
    case 6:
      text.insert(at, n, static_cast<char>(by.byte()));
      break;
    default: {
      const std::string piece = text.substr(first + by.byte() * 256u % room, n);
      text.replace(at, piece.size(), piece);
    }
  }
}
/// With the length and the checksum that fit.
std::string sealed(std::string text) {
  const std::uint64_t length = text.size() - detail::checkpoint_head;
  std::memcpy(text.data() + 16, &length, sizeof length);
  const std::uint64_t end = checksum(std::as_bytes(std::span(text)));
  return text.append(reinterpret_cast<const char*>(&end), sizeof end);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes in(data, size);
  const int which = in.below(programs), done = in.below(4), mode = in.below(4);
  // What each program writes after so many steps is the same every time.
  static std::array<std::array<std::string, 4>, programs> written;
  std::string& good = written[static_cast<std::size_t>(which)][static_cast<std::size_t>(done)];
  if (good.empty())
    with_program(which, [&](auto program) {
      for (int k = 0; k < 3 * done; ++k) program->advance();
      good = program->bytes();
    });
  std::string text = good.substr(0, good.size() - 8);
  bool is_sealed = true;
  if (mode == 0) {  // the header, the checksum, anything
    text = good;
    for (int k = 0; k < 4 && in.left() > 0; ++k) edit(text, 0, in);
    is_sealed = false;
  } else if (mode == 1) {  // arbitrary parts
    text.replace(detail::checkpoint_head, std::string::npos, reinterpret_cast<const char*>(in.rest()), in.left());
  } else {
    for (int k = 0; k < 6 && in.left() > 0; ++k) edit(text, detail::checkpoint_head, in);
  }
  if (is_sealed) text = sealed(std::move(text));

  with_program(which, [&](auto program) {
    if (done % 2 == 1) program->advance();
    const std::string before = program->bytes();
    try {
      program->load(text);
    } catch (const CheckpointError&) {
      demand(text != good, "what was written can be read");
      if (program->bytes() == before) return;
      // A run that hasn't begun has read its options; what comes is the same.
      demand(done % 2 == 0, "a refused checkpoint changes nothing");
      with_program(which, [&](auto fresh) {
        if constexpr (std::is_same_v<decltype(fresh), decltype(program)>) {
          program->advance(), fresh->advance();
          demand(program->bytes() == fresh->bytes(), "a refused checkpoint changes nothing that counts");
        }
      });
      return;
    }
    demand(is_sealed || text.starts_with(good), "a checkpoint without its checksum is refused");
    try {
      for (int k = 0; k < 3; ++k) program->advance();
      static_cast<void>(program->bytes());
    } catch (const std::invalid_argument&) {  // masses, boxes and shapes that can't be are said to be so
    }
  });
  return 0;
}
