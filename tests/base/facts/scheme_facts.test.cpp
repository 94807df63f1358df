// The facts of the schemes, as docs/reference/schemes.md has them. (That they are true: scheme_facts.full.cpp.)
#include "base/facts/scheme_facts_cases.hpp"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <type_traits>

#include "support/catch.hpp"

using namespace scheme_facts_cases;

namespace {

using Vec = Eigen::VectorXd;
static_assert(!std::is_default_constructible_v<SchemeFacts> && !std::is_default_constructible_v<ExplicitMotion> &&
                  !std::is_default_constructible_v<AStable>,
              "a fact that is left out doesn't compile");

template <class Scheme>
std::string line(const Scheme& scheme, const std::string& name) {
  constexpr SchemeFacts facts = Scheme::facts;
  using S = std::conditional_t<facts.motion_only, Motion<Vec>, Vec>;
  using On = SchemeOn<Scheme, S>;
  const auto yes = [](bool x) { return x ? std::string("yes") : std::string("-"); };
  S y;
  const int order = On(scheme, y).order();
  return "| `" + name + "` | " + std::to_string(order) + " | " + (facts.motion_only ? "motion" : "any") + " | " +
         (facts.is_explicit ? "explicit" : "implicit") + " | " +
         (facts.is_l_stable   ? "L"
          : facts.is_a_stable ? "A"
                              : "-") +
         " | " + yes(facts.is_symplectic) + " | " + yes(On::traces) + " | " + yes(On::interpolates) + " |\n";
}

}  // namespace

TEST_CASE("docs/reference/schemes.md has the schemes' facts") {
  std::string table =
      "| scheme | order | states | where the force ignores v | stable for all decay | symplectic | estimates its error "
      "| "
      "interpolant of its own |\n|---|---|---|---|---|---|---|---|\n";
  for_each_scheme([&table](const auto& scheme, const char* name) { table += line(scheme, name); });
  std::ifstream in(std::filesystem::path(__FILE__).parent_path() / "../../docs/reference/schemes.md");
  REQUIRE(in);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  INFO("it should have\n" << table);
  CHECK(text.find(table) != std::string::npos);
}
