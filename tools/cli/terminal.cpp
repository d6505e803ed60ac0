// What: Lines and bars on stderr.
// Not: thread-safe: commands report from one thread.
#include "tools/cli/terminal.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <nlohmann/json.hpp>

#include "ingest/files/atomic_file.h"
#include "tools/cli/progress_text.h"

namespace tessera {
namespace {

ProgressBar* current_bar = nullptr;
Verbosity chosen_verbosity = Verbosity::kNormal;

/// A message that cannot be written (standard error is a file on a full disk) is lost: what it
/// reports, and the exit code, matter more than an error of its own.
void print_message(const std::string& text) {
  std::fwrite(text.data(), 1, text.size(), stderr);
}

void print_line(const std::string& line) {
  if (current_bar != nullptr) current_bar->clear();
  print_message(line + "\n");
}

std::string_view variable(const char* name) {
  const char* const value = std::getenv(name);
  return value == nullptr ? "" : value;
}

bool has_colour() {
  return isatty(STDERR_FILENO) == 1 && variable("NO_COLOR").empty() && variable("TERM") != "dumb";
}

}  // namespace

void set_verbosity(Verbosity verbosity) {
  chosen_verbosity = verbosity;
}

Verbosity verbosity() {
  return chosen_verbosity;
}

void say(const std::string& line) {
  if (chosen_verbosity != Verbosity::kQuiet) print_line(line);
}

void warn(const std::string& line) {
  print_line((has_colour() ? "\033[33mwarning:\033[0m " : "warning: ") + line);
}

void report_error(const std::string& line) {
  print_line(line);
}

int terminal_columns() {
  constexpr int kDefault = 80;
  winsize size{};
  if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0) return size.ws_col;
  const int columns = std::atoi(std::string(variable("COLUMNS")).c_str());
  return columns > 0 ? columns : kDefault;
}

void print_result(bool as_json, const nlohmann::json& json, const std::string& text) {
  const std::string result =
      as_json ? json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) : text;
  if (std::fwrite(result.data(), 1, result.size(), stdout) != result.size() ||
      std::fputc('\n', stdout) == EOF || std::fflush(stdout) != 0)
    throw WriteError(fmt::format("standard output cannot be written ({})", std::strerror(errno)));
}

std::string clock_time(double seconds) {
  const int64_t whole = int64_t(seconds + 0.5);
  return whole < 3600 ? fmt::format("{}:{:02}", whole / 60, whole % 60)
                      : fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
}

std::string duration_text(double seconds) {
  return seconds < 59.95 ? fmt::format("{:.1f} s", seconds) : clock_time(seconds);
}

std::string size_text(int64_t bytes) {
  return bytes < 1'000'000 ? fmt::format("{:.1f} kB", double(bytes) / 1e3)
                           : fmt::format("{:.1f} MB", double(bytes) / 1e6);
}

ProgressBar::ProgressBar(std::string label)
    : label_(std::move(label)),
      begin_(std::chrono::steady_clock::now()),
      drawn_(begin_),
      on_terminal_(isatty(STDERR_FILENO) == 1) {
  current_bar = this;
}

ProgressBar::~ProgressBar() {
  clear();
  current_bar = nullptr;
}

void ProgressBar::clear() {
  if (visible_) print_message("\r\033[K");
  visible_ = false;
}

void ProgressBar::update(int64_t done, int64_t total, std::string_view note, int64_t first) {
  const auto now = std::chrono::steady_clock::now();
  if (total != total_ || done < done_) begin_ = now;
  done_ = done;
  total_ = total;
  if (chosen_verbosity == Verbosity::kQuiet) return;
  const double since_drawn = std::chrono::duration<double>(now - drawn_).count();
  if (since_drawn < (on_terminal_ ? 0.1 : 10.0)) return;
  drawn_ = now;
  const Progress progress{done, total, first, std::chrono::duration<double>(now - begin_).count()};
  if (!on_terminal_) {
    print_message(progress_line(label_, progress, note) + "\n");
    return;
  }
  print_message("\r\033[K" + bar_line(label_, progress, note, terminal_columns()));
  std::fflush(stderr);
  visible_ = true;
}

}  // namespace tessera
