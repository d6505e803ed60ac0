// What: counts, share and the time that is left at the speed so far.
// Not: a guess of a total.
#include "tools/cli/progress_text.h"

#include <fmt/format.h>

#include "tools/cli/terminal.h"

namespace tessera {
namespace {

bool has_total(const Progress& progress) {
  return progress.total > 0 && progress.done <= progress.total;
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

}  // namespace tessera
