/// @file
/// Other programs, run and read.
#pragma once

#include <cstdio>
#include <stdexcept>
#include <string>

namespace bench {

/// For the shell: one word, whatever is in it.
[[nodiscard]] inline std::string quoted(const std::string& word) {
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

struct Output {
  int status = -1;   ///< 0: the program ended well
  std::string text;  ///< what it printed
};

[[nodiscard]] inline Output run_program(const std::string& command) {
  Output output;
  std::FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  if (!pipe) throw std::runtime_error("cannot run " + command);
  char buffer[4096];
  for (std::size_t n = 0; (n = std::fread(buffer, 1, sizeof buffer, pipe)) > 0;) output.text.append(buffer, n);
  output.status = pclose(pipe);
  return output;
}

}  // namespace bench
