// What: Counts, share, a bar and the time that is left at the speed so far.
// Not: a guess of a total.
#include "tools/cli/progress_text.h"

#include <fmt/format.h>

#include <algorithm>

#include "tools/cli/terminal.h"

namespace tessera {
namespace {

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

double progress_share(const Progress& progress) {
  return has_total(progress) ? double(progress.done) / double(progress.total) : 0;
}

std::string progress_text(const Progress& progress) {
  const auto& [done, total, first, seconds] = progress;
  if (!has_total(progress)) return done > 0 ? fmt::format("{} done", done) : "";
  std::string text = fmt::format("{}/{} ({:.0f} %)", done, total, 100 * progress_share(progress));
  if (done > first)
    text +=
        fmt::format(" {} left", clock_time(seconds * double(total - done) / double(done - first)));
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

}  // namespace tessera
