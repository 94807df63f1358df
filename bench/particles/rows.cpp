#include "frontier.hpp"

#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <stdexcept>

#ifdef _OPENMP
#include <omp.h>
#endif

namespace bench {

void Table::add(Figure figure) {
  std::printf("  %-52s %9ld %2d  %12.6g %s\n", figure.name.c_str(), figure.particles, figure.threads, figure.value,
              figure.unit.c_str());
  std::fflush(stdout);
  figures_.push_back(std::move(figure));
}

void Table::rates(const std::string& row, long particles, double work, const std::string& unit,
                  const std::vector<Entrant>& entrants, const std::vector<std::string>& against) {
  std::vector<double> yardsticks;
  for (const std::string& name : against)
    for (const Entrant& e : entrants)
      if (e.name == name && e.threads == 1) {
        if (yardsticks.empty()) std::printf("  ratios to");
        std::printf("%s %s", yardsticks.empty() ? "" : ";", name.c_str());
        yardsticks.push_back(work / e.median());
      }
  if (!yardsticks.empty()) std::printf(":\n");
  for (const Entrant& e : entrants) {
    if (e.times.empty() || !(e.median() > 0)) continue;
    const double rate = work / e.median();
    const double fastest = work / *std::min_element(e.times.begin(), e.times.end());
    std::printf("  %-52s %9ld %2d  %9.3f %s", e.name.c_str(), particles, e.threads, rate / 1e6, unit.c_str());
    for (const double tolerance : yardsticks) std::printf(" %5.2f x", rate / tolerance);
    std::printf("   (best %.3f)\n", fastest / 1e6);
    figures_.push_back({row, e.name, particles, e.threads, "rate", unit, rate / 1e6});
  }
  std::fflush(stdout);
}

void Table::write(const std::string& path, const std::string& compiled_with) const {
  std::ofstream csv(path);
  csv.precision(8);
  csv << "row,name,particles,threads,quantity,value,unit,compiled_with\n";
  for (const Figure& f : figures_)
    csv << f.row << ",\"" << f.name << "\"," << f.particles << ',' << f.threads << ',' << f.quantity << ',' << f.value
        << ",\"" << f.unit << "\",\"" << compiled_with << "\"\n";
  if (!csv) throw std::runtime_error("cannot write " + path);
}

double resident_megabytes() {
  std::ifstream statm("/proc/self/statm");
  double pages = 0, resident = 0;
  if (!(statm >> pages >> resident)) return 0;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

std::string as_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

void write_rungs(const Options& options, const std::string& name, const std::string& scene,
                 const std::vector<Rung>& rungs, bool is_first) {
  const std::string path = options.out + "/particles_" + name + ".csv";
  std::ofstream csv(path, is_first ? std::ios::trunc : std::ios::app);
  csv.precision(8);
  if (is_first) csv << "scene,method,dt,error,drift,seconds\n";
  for (const Rung& rung : rungs)
    csv << scene << ',' << rung.method << ',' << rung.dt << ',' << rung.error << ',' << rung.drift << ','
        << rung.entrant.median() << '\n';
  if (!csv) throw std::runtime_error("cannot write " + path);
}

void use_threads([[maybe_unused]] int n) {
#ifdef _OPENMP
  omp_set_num_threads(n);
#endif
}

int most_threads() {
#ifdef _OPENMP
  return omp_get_num_procs();
#else
  return 1;
#endif
}

}  // namespace bench
