// Checkpoints of fields: the run that resumes goes on with the bits of the one that saved; what doesn't fit is refused.
// Those of several ranks are in adapters/rank_cases.hpp.
#include "embed/field_cases.hpp"
#include "support/catch.hpp"

#include <filesystem>
#include <vector>

using namespace phistep;
using fields::Diagonal;

namespace {
const std::filesystem::path file = std::filesystem::temp_directory_path() / "phistep_rank_checkpoint";

void resume(const auto& scheme, const auto& control, bool edited = false) {
  LocalField y = local_field({1, 2, 3});
  PhiStepper stepper{y, fields::Decay{}, scheme, newton(Diagonal{})};
  Run run{stepper, y, {0.0, 1.0}, control};
  for (int k = 0; k < 7; ++k) REQUIRE(run.advance());
  if (edited) y *= 1.01;
  save_on_ranks(y, file, run);
  LocalField z = local_field({7, 7, 7});
  PhiStepper anew{z, fields::Decay{}, scheme, newton(Diagonal{})};
  Run resumed{anew, z, {0.0, 1.0}, control};
  REQUIRE(load_on_ranks(z, file, resumed));
  CHECK(numbers(y) == numbers(z));
  const RunReport expected = run.finish(), report = resumed.finish();
  REQUIRE(report);
  CHECK(numbers(y) == numbers(z));
  CHECK(report.statistics.steps == expected.statistics.steps);
  CHECK(report.largest_dt == expected.largest_dt);
}
}  // namespace

TEST_CASE("a run on a field resumes with the bits of the run that saved") {
  const tolerance control{.rtol = 1e-5, .atol = 1e-5};
  for (const auto& c : {control, tolerance{.rtol = 1e-5}}) {
    resume(rodas4, c);
    resume(tr_bdf2, c);
    resume(trapezoidal, c);
    resume(trapezoidal, c, true);
    resume(tsit5, c);
    resume(dop853, c);
  }
  resume(forward_euler, fixed(0.01));
  resume(phi(0.7), fixed(0.01));
}
TEST_CASE("saves follow each other, and one remains") {
  LocalField y = local_field({1, 2, 3});
  const auto part = [](int save) { return detail::RankManifest{save, 1}.part(file, 0); };
  std::filesystem::remove(file);
  CHECK_FALSE(load_on_ranks(y, file, y));
  save_on_ranks(y, file, y);
  CHECK(std::filesystem::exists(part(1)));
  numbers(y)[0] = 5;
  save_on_ranks(y, file, y);
  CHECK_FALSE(std::filesystem::exists(part(1)));
  CHECK(std::filesystem::exists(part(2)));
  LocalField z = local_field({0, 0, 0});
  REQUIRE(load_on_ranks(z, file, z));
  CHECK(numbers(z) == std::vector<double>{5, 2, 3});
}
TEST_CASE("what doesn't fit is refused in words, and changes nothing") {
  LocalField y = local_field({1, 2, 3});
  save_on_ranks(y, file, y);
  LocalField longer = local_field({4, 4, 4, 4});
  CHECK_THROWS_WITH(load_on_ranks(longer, file, longer), Catch::Contains("of another size: 3 x 1 there, 4 x 1 here"));
  CHECK(numbers(longer) == std::vector<double>{4, 4, 4, 4});
  detail::RankManifest manifest;
  REQUIRE(load_checkpoint(file, manifest));
  save_checkpoint(file, detail::RankManifest{manifest.save, 3});
  CHECK_THROWS_WITH(load_on_ranks(y, file, y), Catch::Contains("was written by 3 ranks, here are 1"));
  save_checkpoint(file, detail::RankManifest{manifest.save + 1, 1});
  CHECK_THROWS_WITH(load_on_ranks(y, file, y), Catch::Contains("can't be opened"));
  std::filesystem::copy_file(manifest.part(file, 0), detail::RankManifest{manifest.save + 1, 1}.part(file, 0));
  CHECK_THROWS_WITH(load_on_ranks(y, file, y),
                    Catch::Contains("here it is \"rank 0 of 1, save " + std::to_string(manifest.save + 1)));
  CHECK(numbers(y) == std::vector<double>{1, 2, 3});
  std::filesystem::remove(file);
}
