/// @file
/// A ParaView collection (.pvd): the times of a series of VTK files, and their names relative to it. io/vtk.hpp is its face.
#pragma once

#include <cerrno>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "phistep/core/version.hpp"
#include "phistep/io/text.hpp"
#include "phistep/io/text_reader.hpp"
#include "phistep/io/vtk/file.hpp"

namespace phistep { inline namespace PHISTEP_ABI {

/// out/melt.pvd lists melt/00000.vtp, melt/00001.vtp, … It is a complete file after each frame.
class VtkCollection {
 public:
  /// @param base       "out/melt": of out/melt.pvd and the folder out/melt ("out/melt.pvd" does as well)
  /// @param extension  of the frames: ".vtp"
  VtkCollection(std::filesystem::path base, std::string extension)
      : folder_(std::move(base)), extension_(std::move(extension)) {
    if (folder_.extension() == ".pvd") folder_.replace_extension();
    if (folder_.filename().empty()) throw std::invalid_argument("phistep: a series of VTK files needs a name");
    path_ = folder_;
    path_ += ".pvd";
  }

  [[nodiscard]] std::size_t size() const { return times_.size(); }
  [[nodiscard]] const std::vector<double>& times() const { return times_; }  ///< [time]
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

  /// The frames that the file lists; none where there is no file.
  /// @throws std::runtime_error where it can't be read, or lists others than such a series has
  void read() {
    times_.clear(), sign_ = 0, is_written_ = false;
    errno = 0;
    std::ifstream in(path_, std::ios::binary);
    std::error_code error;
    if (!in && !std::filesystem::exists(path_, error) && !error) return;
    if (!in) detail::fail_file("cannot read", path_, detail::last_error());
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    if (text.find("type=\"Collection\"") == text.npos) refuse("is no ParaView collection");
    static constexpr std::string_view start = "<DataSet timestep=\"";
    for (std::size_t at = text.find(start); at != text.npos; at = text.find(start, at)) {
      at += start.size();
      const std::size_t end = text.find("/>\n", at);
      if (end == text.npos) break;  // cut off: the frame was not finished
      double t = 0;
      const char* const last = text.data() + end;
      if (detail::from_chars(text.data() + at, last, t).ec != std::errc{}) refuse("has a time that is no number");
      if (text.substr(at - start.size(), end + 3 - at + start.size()) != entry(times_.size(), t))
        refuse("lists other files than this series would; choose another name, or don't resume");
      append(t);
    }
  }

  /// Makes room for a frame at t: those at t, and those that a run passes after t, are taken from the list. Returns its
  /// path; its folder is there. [time]
  [[nodiscard]] std::filesystem::path next(double t) {
    while (!times_.empty() && !goes_on_at(t)) times_.pop_back(), is_written_ = false;
    if (times_.empty()) sign_ = 0;
    if (!is_written_) write();
    std::error_code error;
    std::filesystem::create_directory(folder_, error);
    if (error) detail::fail_file("cannot make the folder", folder_, error);
    return folder_ / name(times_.size());
  }
  /// The frame at t, which next(t) has named, has been written. [time]
  void add(double t) {
    const std::string line = entry(times_.size(), t);
    // Behind the last entry, over the closing tags: longer than what it replaces, so the file is always complete.
    errno = 0;
    std::fstream out(path_, std::ios::binary | std::ios::in | std::ios::out | std::ios::ate);
    const std::streamoff length = out ? std::streamoff{out.tellp()} : -1;
    append(t);
    if (length != length_) return write();  // not the file that was written here
    out.seekp(length_ - static_cast<std::streamoff>(closing.size()));
    out << line + std::string(closing);
    out.close();
    if (!out) {
      times_.pop_back(), is_written_ = false;
      detail::fail_file("writing failed:", path_, detail::last_error());
    }
    length_ += static_cast<std::streamoff>(line.size());
  }

 private:
  static constexpr std::string_view closing = "  </Collection>\n</VTKFile>\n";

  /// Whether t comes after the last frame, in the direction of the first two.
  [[nodiscard]] bool goes_on_at(double t) const {
    return sign_ == 0 ? t != times_.back() : sign_ * (t - times_.back()) > 0;
  }
  void append(double t) {
    if (!times_.empty()) sign_ = t > times_.back() ? 1 : -1;
    times_.push_back(t);
  }
  [[nodiscard]] std::string name(std::size_t k) const {
    std::string digits = std::to_string(k);
    if (digits.size() < 5) digits.insert(0, 5 - digits.size(), '0');
    return digits + extension_;
  }
  [[nodiscard]] std::string entry(std::size_t k, double t) const {
    std::string text = "<DataSet timestep=\"";
    append_number(text, t);
    return text + "\" part=\"0\" file=\"" + detail::escaped(detail::utf8(folder_.filename() / name(k))) + "\"/>\n";
  }
  void write() {
    is_written_ = false;
    std::string text =
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n  <Collection>\n";
    for (std::size_t k = 0; k < times_.size(); ++k) text += entry(k, times_[k]);
    text += closing;
    detail::replace_file(path_, text);
    length_ = static_cast<std::streamoff>(text.size());
    is_written_ = true;
  }
  [[noreturn]] void refuse(const char* why) const {
    throw std::runtime_error("phistep: " + detail::utf8(path_) + ' ' + why);
  }

  std::filesystem::path folder_, path_;
  std::string extension_;
  std::vector<double> times_;
  std::streamoff length_ = 0;
  double sign_ = 0;          // whether time runs forward (1) or backward (−1); 0: unknown
  bool is_written_ = false;  // whether the file lists times_
};

}}  // namespace phistep::PHISTEP_ABI
