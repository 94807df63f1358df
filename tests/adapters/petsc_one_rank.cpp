// petsc_one_rank throws | stops | event | all: the last rank alone ends its run of y' = −y, by an observer that throws, by one that
// returns false, by an event's function that is NaN; or all ranks end theirs. Right is that every rank comes out of the run. Those
// that don't within 5 s say so. To be run on 2 ranks.
#include <unistd.h>
#include <phistep/petsc.hpp>
#include <phistep/phistep.hpp>

#include <csignal>
#include <cstdio>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>

using namespace phistep;

namespace {
char waits[] = "rank 0 waits in the run\n";

void give_up(int) {
  const auto written = write(STDOUT_FILENO, waits, sizeof waits - 1);
  MPI_Abort(PETSC_COMM_WORLD, written < 0 ? 3 : 2);
}

/// How the run of this rank ended.
std::string run(std::string_view what, bool is_last) {
  Vec ones = nullptr;
  check_petsc(VecCreateMPI(PETSC_COMM_WORLD, PETSC_DECIDE, 100, &ones));
  check_petsc(VecSet(ones, 1));
  PetscField y{ones};
  PhiStepper stepper{y, PetscForce{[](Vec x, Vec out) { return VecAXPBY(out, -1, 0, x); }}, tsit5};
  int calls = 0;
  const auto observer = [&](double, const PetscField&) {
    if (++calls < 3) return true;
    if (what == "throws" && is_last) throw std::runtime_error("the disk is full");
    return what != "all" && !(what == "stops" && is_last);
  };
  auto never = event([&](double t, const PetscField&) {
    return what == "event" && is_last && t > 0.03 ? std::numeric_limits<double>::quiet_NaN() : -1.0;
  });
  try {
    return describe(integrate(stepper, y, {0.0, 0.5}, fixed(0.01), observer, never).outcome);
  } catch (const std::exception& error) {
    return error.what();
  }
}
}  // namespace

int main(int argc, char** argv) {
  const std::string_view what = argc > 1 ? argv[1] : "";
  if (what != "throws" && what != "stops" && what != "event" && what != "all") return 1;
  PetscInitializeNoArguments();
  int rank = 0, ranks = 1;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  waits[5] = static_cast<char>('0' + rank);
  std::signal(SIGALRM, give_up);
  alarm(5);
  const std::string end = run(what, rank == ranks - 1);
  alarm(0);
  std::printf("rank %d is out of the run: %s\n", rank, end.c_str());
  std::fflush(stdout);
  MPI_Barrier(PETSC_COMM_WORLD);
  if (rank == 0) std::puts("all ranks are out of the run");
  return PetscFinalize();
}
