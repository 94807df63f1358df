/// @file
/// How much is lost by not choosing: integrate(y, f, …) beside each scheme picked by hand, at equal error, and beside LSODA and
/// DOP853 (NUMBALSODA=<folder of liblsoda.so>), CVODE, GSL and Odeint on problems of at most 100 unknowns.
///     bench_automatic [--problem TEXT] [--longest SECONDS] [--told RTOL]
///
/// CPU time of the thread, all of a run included; the least of five rounds in turns; the time to an error on the line between
/// two tolerances of a ladder by half decades.
#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <map>
#include <numeric>

#include "../equal_error.hpp"
#include "rows.hpp"

namespace automatic {
namespace {

std::string only;
double longest = 0.3;  // [s] tighter rungs are left out after one that takes longer
double told = 0;
double logs = 0, logs_of_advised = 0;
std::map<std::string, std::vector<double>> ahead;  // their time / that of automatic, a rival each
struct Rows {
  const char* of;
  std::vector<double> logs{};
  std::string worst{};
  void add(double ratio, const std::string& row) {
    if (logs.empty() || std::log(ratio) < *std::min_element(logs.begin(), logs.end())) worst = row;
    logs.push_back(std::log(ratio));
  }
};
Rows by_hand[3] = {{"by hand, 1e-3"}, {"by hand, 1e-6"}, {"by hand, 1e-9"}},
     by_itself[3] = {
         {"automatic, 1e-3"}, {"automatic, 1e-6"}, {"automatic, 1e-9"}};  // the quickest rival's time / ours
int count = 0, misses = 0, advised_count = 0, advised_misses = 0;

[[nodiscard]] std::optional<double> time_to(double wanted, const Ladder& ladder) {
  std::vector<std::pair<double, double>> runs;
  for (const Rung& rung : ladder.rungs)
    if (rung.error < 0.3) runs.emplace_back(rung.seconds, rung.error);
  return bench::time_to_error(wanted, std::move(runs));
}
/// The tolerance at which the ladder has that error, about.
[[nodiscard]] double rtol_for(double wanted, const Ladder& ladder) {
  for (const Rung& rung : ladder.rungs)
    if (rung.error <= wanted) return rung.rtol;
  return ladder.rungs.back().rtol;
}

}  // namespace

void measure(Problem problem) {
  if (problem.name.find(only) == std::string::npos) return;
  if (told > 0) {
    std::printf("%s\n%s", problem.name.c_str(), problem.told(told).c_str());
    return;
  }
  std::vector<Ladder*> all{&problem.automatic};
  for (Ladder& ladder : problem.hand) all.push_back(&ladder);
  for (Ladder& ladder : problem.rivals) all.push_back(&ladder);
  double limit = longest;  // the first, automatic's; of the others what takes 20 times as long can't be the quickest
  for (Ladder* ladder : all) {
    double slowest = 0;
    for (double k = 2; k <= -std::log10(problem.tightest) + 0.1; k += 0.5) {
      Rung rung{std::pow(10.0, -k)};
      const double start = now();
      rung.error = ladder->run(rung.rtol);
      rung.seconds = now() - start;
      if (std::isfinite(rung.error)) ladder->rungs.push_back(rung);
      if (rung.seconds > limit) break;
      slowest = std::max(slowest, rung.seconds);
    }
    if (ladder == all.front()) limit = std::min(longest, 20 * slowest);
  }
  for (int round = 0; round < 5; ++round)
    for (Ladder* ladder : all)
      for (Rung& rung : ladder->rungs) {
        const int repeats = std::max(1, static_cast<int>(1e-3 / rung.seconds));
        const double start = now();
        for (int k = 0; k < repeats; ++k) static_cast<void>(ladder->run(rung.rtol));
        rung.seconds = std::min(rung.seconds, (now() - start) / repeats);
      }
  std::printf("%s\n", problem.name.c_str());
  for (const double wanted : {1e-3, 1e-6, 1e-9}) {
    const Ladder* best = nullptr;
    double least = INFINITY;
    for (const Ladder& ladder : problem.hand)
      if (const auto time = time_to(wanted, ladder); time && *time < least) least = *time, best = &ladder;
    if (best == nullptr) continue;
    const std::string advised = problem.advised(rtol_for(wanted, problem.automatic));
    const auto time = time_to(wanted, problem.automatic);
    std::printf("  %.0e  %-8s %10.2f us", wanted, best->name.c_str(), 1e6 * least);
    if (time) {
      const double ratio = std::max((*time - 2e-6) / least, 0.0), plain = *time / least;
      std::printf("   automatic %10.2f us  %5.2f x%s", 1e6 * *time, plain, ratio > 1.3 ? "  <- miss" : "");
      logs += std::log(plain), ++count;
      misses += ratio > 1.3;
    } else {
      std::printf("   automatic not reached  <- miss");
      ++count, ++misses;
    }
    for (const Ladder& ladder : problem.hand)
      if (ladder.name == advised) {
        const auto its = time_to(wanted, ladder);
        const double ratio = its ? *its / least : 99;
        std::printf("   advised %-8s %5.2f x%s", advised.c_str(), ratio, ratio > 1.3 ? "  <- miss" : "");
        logs_of_advised += std::log(ratio), ++advised_count;
        advised_misses += ratio > 1.3;
      }
    for (const Ladder& rival : problem.rivals)
      if (const auto its = time_to(wanted, rival); time && its) {
        std::printf("   %s %.2f x", rival.name.c_str(), *its / *time);
        ahead[rival.name].push_back(std::log(*its / *time));
      } else if (time) {
        std::printf("   %s not reached", rival.name.c_str());
      }
    const Ladder* quickest = nullptr;
    double rivals_least = INFINITY;
    for (const Ladder& rival : problem.rivals)
      if (const auto its = time_to(wanted, rival); its && *its < rivals_least) rivals_least = *its, quickest = &rival;
    if (quickest != nullptr) {
      const int column = wanted > 1e-4 ? 0 : wanted > 1e-7 ? 1 : 2;
      const std::string row = problem.name + ", " + quickest->name;
      std::printf("   best rival / by hand %.2f", rivals_least / least);
      by_hand[column].add(rivals_least / least, row);
      if (time) by_itself[column].add(rivals_least / *time, row);
    }
    std::printf("\n");
  }
  std::fflush(stdout);
}

}  // namespace automatic

int main(int argc, char** argv) {
  using namespace automatic;
  for (int i = 1; i + 1 < argc; i += 2) {
    if (std::strcmp(argv[i], "--problem") == 0) only = argv[i + 1];
    else if (std::strcmp(argv[i], "--longest") == 0) longest = std::atof(argv[i + 1]);
    else if (std::strcmp(argv[i], "--told") == 0) told = std::atof(argv[i + 1]);
  }
  small_problems();
  van_der_pol();
  motions();
  fields();
  sets();
  std::printf("automatic: geometric mean %.3f of the best, %d of %d beyond 1.3 x + 2 us\n", std::exp(logs / count),
              misses, count);
  std::printf("advised:   geometric mean %.3f of the best, %d of %d beyond 1.3 x\n",
              std::exp(logs_of_advised / advised_count), advised_misses, advised_count);
  for (const auto& group : {by_hand, by_itself})
    for (int column = 0; column < 3; ++column) {
      const auto& [of, all, worst] = group[column];
      if (all.empty()) continue;
      std::printf("the quickest rival's time / %s: %.2f, %zu rows, %td of them below 0.87, least %.2f (%s)\n", of,
                  std::exp(std::accumulate(all.begin(), all.end(), 0.0) / static_cast<double>(all.size())), all.size(),
                  std::count_if(all.begin(), all.end(), [](double x) { return x < std::log(0.87); }),
                  std::exp(*std::min_element(all.begin(), all.end())), worst.c_str());
    }
  for (const auto& [name, ratios] : ahead)
    std::printf("%s: %.2f x as long as automatic, geometric mean of %zu rows, least %.2f\n", name.c_str(),
                std::exp(std::accumulate(ratios.begin(), ratios.end(), 0.0) / static_cast<double>(ratios.size())),
                ratios.size(), std::exp(*std::min_element(ratios.begin(), ratios.end())));
}
