// What the examples share: `--out DIR` (where files go, default "out"), `--short` (a quick run), and options of their own.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <utility>

struct CommandLine {
  bool is_short = false;
  std::filesystem::path out = "out";
  std::map<std::string, std::string> own;  // an example's own options, e.g. own["--mesh"], with their defaults

  CommandLine(int argc, char** argv, std::map<std::string, std::string> defaults = {}) : own(std::move(defaults)) {
    for (int i = 1; i < argc; ++i) {
      const std::string name = argv[i];
      if (name == "--short") is_short = true;
      else if (name == "--out" && i + 1 < argc) out = argv[++i];
      else if (own.contains(name) && i + 1 < argc) own[name] = argv[++i];
      else stop("usage: " + std::string(argv[0]) + " [--short] [--out DIR]" + own_options());
    }
    std::error_code error;
    std::filesystem::create_directories(out, error);
    if (error) stop("can't make the folder " + out.string() + ": " + error.message());
  }

  /// A file in the output folder, open for writing.
  [[nodiscard]] std::ofstream file(const std::string& name) const {
    std::ofstream stream(out / name);
    if (!stream) stop("can't write " + (out / name).string());
    stream.precision(12);
    return stream;
  }

  /// An own option that is a whole number; `fallback` where it isn't given.
  [[nodiscard]] long whole(const std::string& name, long fallback, long least) const {
    const std::string& text = own.at(name);
    if (text.empty()) return fallback;
    char* end = nullptr;
    const long number = std::strtol(text.c_str(), &end, 10);
    if (*end != '\0' || number < least) stop(name + " needs a whole number of at least " + std::to_string(least));
    return number;
  }

  [[noreturn]] static void stop(const std::string& why) {
    std::fprintf(stderr, "%s\n", why.c_str());
    std::exit(2);
  }

 private:
  [[nodiscard]] std::string own_options() const {
    std::string text;
    for (const auto& [name, value] : own)
      text += " [" + name + " VALUE" + (value.empty() ? "" : ", default " + value) + "]";
    return text;
  }
};
