// What: lines and bars on stderr.
// Not: thread-safe: commands report from one thread.
#include "tools/cli/terminal.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>

#include "ingest/files/write_failure.h"
#include "tools/cli/progress_text.h"

namespace tessera {
namespace {

constexpr int kBarWidth = 28;  // characters
ProgressBar* current_bar = nullptr;

/// A message that cannot be written (standard error is a file on a full disk) is lost: what it
/// reports, and the exit code, matter more than an error of its own.
void print_message(const std::string& text) {
  std::fwrite(text.data(), 1, text.size(), stderr);
}

}  // namespace

void say(const std::string& line) {
  if (current_bar != nullptr) current_bar->clear();
  print_message(line + "\n");
}

void warn(const std::string& line) {
  say("warning: " + line);
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
  const double since_drawn = std::chrono::duration<double>(now - drawn_).count();
  if (since_drawn < (on_terminal_ ? 0.1 : 10.0)) return;
  drawn_ = now;
  const Progress progress{done, total, first, std::chrono::duration<double>(now - begin_).count()};
  const std::string text = progress_text(progress);
  const char* blank = text.empty() ? "" : " ";
  if (!on_terminal_) {
    print_message(fmt::format("{}{}{} {}\n", label_, blank, text, note));
    return;
  }
  const int filled = int(progress_share(progress) * kBarWidth);
  print_message(fmt::format("\r\033[K{} [{}{}]{}{} {}", label_, std::string(size_t(filled), '='),
                            std::string(size_t(kBarWidth - filled), ' '), blank, text, note));
  std::fflush(stderr);
  visible_ = true;
}

}  // namespace tessera
