// expect: this type can't be archived
#include <phistep/base/archive/archive.hpp>

struct Node {
#ifdef MUST_FAIL
  std::vector<double*> memory;
#else
  std::vector<double> memory;
#endif
  void archive(auto& ar) { ar(memory); }
};

int main() {
  phistep::Writer out;
  out(Node{});
}
