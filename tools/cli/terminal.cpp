// Formats and draws messages and bars. It is not thread-safe: commands report from one thread.
#include "tools/cli/terminal.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <nlohmann/json.hpp>

#include "ingest/files/atomic_file.h"
#include "ingest/files/json_file.h"
#include "tools/session/session_observer.h"

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

bool has_total(const Progress& progress) {
  return progress.total > 0 && progress.done <= progress.total;
}

constexpr int kLongestBar = 28, kShortestBar = 4;  // characters between the brackets

bool continues_character(char c) {
  return (static_cast<unsigned char>(c) & 0xC0) == 0x80;  // of UTF-8
}

int columns_of(std::string_view text) {
  return int(
      std::count_if(text.begin(), text.end(), [](char c) { return !continues_character(c); }));
}

std::string cut(const std::string& text, int columns) {
  size_t end = 0;
  for (int used = 0; end < text.size(); ++end)
    if (!continues_character(text[end]) && used++ == std::max(0, columns)) break;
  return text.substr(0, end);
}

std::string joined(std::string_view a, std::string_view b) {
  return fmt::format("{}{}{}", a, a.empty() || b.empty() ? "" : " ", b);
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

void print_result(bool as_json, const nlohmann::json& object, const std::string& text) {
  const std::string result = as_json ? json_text(object, 2) : text;
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

double progress_share(const Progress& progress) {
  return has_total(progress) ? double(progress.done) / double(progress.total) : 0;
}

std::string progress_text(const Progress& progress) {
  const auto& [done, total, first, seconds] = progress;
  if (!has_total(progress)) return done > 0 ? fmt::format("{} done", done) : "";
  std::string text = fmt::format("{}/{} ({:.0f} %)", done, total, 100 * progress_share(progress));
  if (done > first)
    text += fmt::format(" {} left", clock_time(seconds_left(seconds, done - first, total - done)));
  return text;
}

std::string progress_line(std::string_view label, const Progress& progress, std::string_view note) {
  return joined(joined(label, progress_text(progress)), note);
}

std::string bar_line(std::string_view label, const Progress& progress, std::string_view note,
                     int columns) {
  const int most = columns - 1;  // a character in the last column makes some terminals wrap
  const std::string text = progress_text(progress);
  const int around = columns_of(joined(label, text)) + 3;  // the brackets and a blank
  const int with_note = around + kLongestBar + (note.empty() ? 0 : 1 + columns_of(note));
  const std::string_view shown = with_note <= most ? note : "";
  const int length = std::min(kLongestBar, most - around);
  if (length < kShortestBar) return cut(progress_line(label, progress, ""), most);
  const int filled = int(progress_share(progress) * length);
  const std::string bar = fmt::format("[{:<{}}]", std::string(size_t(filled), '='), length);
  return joined(joined(joined(label, bar), text), shown);
}

void add_verbosity(CLI::App& app) {
  const auto every_command = [](const CLI::App*) { return true; };
  for (CLI::App* command : app.get_subcommands(every_command)) {
    CLI::Option* const quiet = command->add_flag_callback(
        "-q,--quiet", [] { set_verbosity(Verbosity::kQuiet); }, "print warnings and errors only");
    command
        ->add_flag_callback(
            "-v,--verbose", [] { set_verbosity(Verbosity::kVerbose); }, "also print details")
        ->excludes(quiet);
  }
}

}  // namespace tessera
