// LAMMPS data files of any bytes: read, or refused with a std::runtime_error that names a line.

#include <sstream>
#include <stdexcept>
#include <string>

#include "../../adapters/lammps/read_data.hpp"
#include "fuzz/fuzz.hpp"

using namespace phistep;
using fuzz::demand;

namespace {

/// What a scene may rely on.
void check(const auto& particles) {
  const auto n = particles.size();
  demand(particles.r.cols() == n && particles.v.cols() == n && particles.mass().size() == n, "one column a particle");
  demand(particles.r.allFinite() && particles.v.allFinite(), "positions and velocities are finite");
  for (Eigen::Index i = 0; i < n; ++i) demand(particles.mass()[i] > 0, "masses are > 0");
  particles.body().check();
  using P = std::remove_cvref_t<decltype(particles)>;
  auto twice = particles;
  if (n < 1000) twice.add(P{particles});  // ids go on after the largest
  demand(n == 0 || n >= 1000 || twice.size() == 2 * n, "particles can be added");
}
void is_named(const std::runtime_error& error) {
  demand(std::string(error.what()).starts_with("phistep: ") &&
             std::string(error.what()).find(", line ") != std::string::npos,
         "an error names the line");
}

template <class P>
void read(const std::string& text, const LammpsOptions& options) {
  std::istringstream in(text);
  try {
    auto data = read_lammps_data<P>(in, options);
    check(data.atoms);
    for (const auto& bond : data.bonds)
      demand(bond.i >= 0 && bond.j >= 0 && bond.i < data.atoms.size() && bond.j < data.atoms.size(), "bonds have ends");
    data.unwrap();
  } catch (const std::runtime_error& error) {
    is_named(error);
  }
}

}  // namespace

// The first character says which style and which particles, the rest is the text.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string text(reinterpret_cast<const char*>(data) + 1, size - 1);
  static const char* const styles[] = {"", "atomic", "sphere", "full"};
  const int mode = data[0] % 8;
  if (mode < 4) read<Particles<double, 3, Spin>>(text, {.style = styles[mode]});
  else read<Particles<float, 2>>(text, {});
  return 0;
}
