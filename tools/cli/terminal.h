// What: what a person sees on stderr: messages, and a progress bar with ETA on a terminal or a
//       plain line now and then otherwise.
// Not: results; those go to stdout (print_result).
#pragma once
#include <chrono>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace tessera {

/// One line on stderr, with a running progress bar moved out of the way.
void say(const std::string& line);
void warn(const std::string& line);

/// The result of a command on stdout: one JSON object with --json, else the given text.
void print_result(bool as_json, const nlohmann::json& json, const std::string& text);

/// "12:34" or "1:02:03".
std::string clock_time(double seconds);

/// A bar for the stages of one command: its clock restarts where counting does. Call `update` as
/// often as you like; it draws ten times a second on a terminal and every ten seconds elsewhere.
class ProgressBar {
 public:
  explicit ProgressBar(std::string label);
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;
  ~ProgressBar();
  /// `first` is where counting began (a resumed run): the ETA is by what was done since.
  void update(int64_t done, int64_t total, std::string_view note = {}, int64_t first = 0);
  void clear();

 private:
  std::string label_;
  std::chrono::steady_clock::time_point begin_, drawn_;
  int64_t done_ = 0, total_ = 0;  // of the last call: fewer, or of another total, is a new stage
  bool on_terminal_, visible_ = false;
};

}  // namespace tessera
