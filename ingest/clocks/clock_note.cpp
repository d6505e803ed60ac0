// Counts the sources of the clocks and finds the largest offset.
#include "ingest/clocks/clock_note.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <map>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

/// The word of the help of --sync and --offsets for a source; empty for "none".
std::string source_text(const std::string& source) {
  if (source == "stated") return "the offsets of --offsets";
  if (source == "container") return "the times in the files (timecode)";
  if (source == "audio") return "sound";
  if (source == "motion") return "motion";
  return "";
}

}  // namespace

std::string clock_note(const std::vector<std::string>& cameras,
                       const std::vector<ClipClock>& clocks) {
  check(!clocks.empty() && cameras.size() == clocks.size(), "clock_note: one clock a camera");
  std::map<std::string, size_t> counts;  // by the text of the source
  size_t farthest = 0;
  for (size_t i = 0; i < clocks.size(); ++i) {
    const std::string text = source_text(clocks[i].source);
    if (!text.empty()) ++counts[text];
    if (std::abs(clocks[i].offset) > std::abs(clocks[farthest].offset)) farthest = i;
  }
  if (counts.empty()) return "clocks: the times of the files are taken as they are";
  std::vector<std::string> sources;
  for (const auto& [text, count] : counts)
    sources.push_back(count == clocks.size()
                          ? text
                          : fmt::format("{} ({} of {} cameras)", text, count, clocks.size()));
  const double most = std::abs(clocks[farthest].offset);
  if (most == 0)
    return fmt::format("clocks: compared by {}; none needed a change", fmt::join(sources, ", "));
  return fmt::format("clocks: aligned by {}, by up to {:.4f} s ({})", fmt::join(sources, ", "),
                     most, cameras[farthest]);
}

}  // namespace tessera
