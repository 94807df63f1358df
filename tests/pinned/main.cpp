#include <string>

#include "pinned/pinned.hpp"

int main(int argc, char** argv) {
  if (argc == 3 && std::string(argv[1]) == "--only") pinned::only = argv[2];
  for (const pinned::Group group : pinned::groups()) group();
  return pinned::failed == 0 ? 0 : 1;
}
