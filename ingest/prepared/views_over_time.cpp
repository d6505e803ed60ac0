// Single frames that stand out do not make a key a time.
#include "ingest/prepared/views_over_time.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "ingest/files/atomic_file.h"

namespace tessera {
namespace {

constexpr size_t kStandOut = 10;  // one of so many frames does not decide

}  // namespace

ViewsOverTime::ViewsOverTime(const std::vector<TransformsFrame>& frames,
                             const std::vector<int>& views)
    : frames_(frames), views_(views) {
  std::map<std::pair<Split, int>, Frames> groups;
  for (size_t i = 0; i < views.size(); ++i) groups[{frames[i].split, views[i]}].push_back(i);
  for (auto& [view, group] : groups)
    if (group.size() > 1 && images_differ(group)) changing_.push_back(std::move(group));
}

size_t ViewsOverTime::changing_frames() const {
  size_t count = 0;
  for (const Frames& group : changing_) count += group.size();
  return count;
}

bool ViewsOverTime::is_on_all(const std::string& key) const {
  return std::all_of(frames_.begin(), frames_.end(), [&](const TransformsFrame& frame) {
    const auto found = frame.other_times.find(key);
    return found != frame.other_times.end() && std::isfinite(found->second);
  });
}

bool ViewsOverTime::has_several(const std::string& key) const {
  return std::any_of(frames_.begin(), frames_.end(), [&](const TransformsFrame& frame) {
    return frame.other_times.at(key) != value(0, key);
  });
}

bool ViewsOverTime::follows_time(const std::string& key) const {
  return has_several(key) &&
         (kStandOut * changing_with(key) > frames_.size() || 2 * sharing(key) > frames_.size());
}

bool ViewsOverTime::counts_through(const std::string& key) const {
  return changing_.size() > 1 && sharing(key) == 0;
}

bool ViewsOverTime::repeats(const std::string& key) const {
  return std::any_of(changing_.begin(), changing_.end(), [&](const Frames& group) {
    return values_of(group, key).size() < group.size();
  });
}

bool ViewsOverTime::disagree(const std::string& one, const std::string& other) const {
  Frames all(frames_.size());
  std::iota(all.begin(), all.end(), size_t(0));
  const std::vector<Frames> whole{all};
  const auto values = [&](size_t i) { return std::pair(value(i, one), value(i, other)); };
  for (Frames group : changing_.empty() ? whole : changing_) {
    std::sort(group.begin(), group.end(),
              [&](size_t a, size_t b) { return values(a) < values(b); });
    for (size_t k = 1; k < group.size(); ++k)
      if (values(group[k]).second < values(group[k - 1]).second) return true;
  }
  return false;
}

double ViewsOverTime::value(size_t frame, const std::string& key) const {
  return frames_[frame].other_times.at(key);
}

std::set<double> ViewsOverTime::values_of(const Frames& group, const std::string& key) const {
  std::set<double> values;
  for (const size_t i : group) values.insert(value(i, key));
  return values;
}

/// How many frames are of views that the key changes in.
size_t ViewsOverTime::changing_with(const std::string& key) const {
  size_t count = 0;
  for (const Frames& group : changing_)
    if (values_of(group, key).size() > 1) count += group.size();
  return count;
}

/// How many frames have a value that an image of another view has, too.
size_t ViewsOverTime::sharing(const std::string& key) const {
  std::map<double, Frames> by_value;
  for (size_t i = 0; i < frames_.size(); ++i) by_value[value(i, key)].push_back(i);
  size_t count = 0;
  for (const auto& [value, group] : by_value) {
    const int view = views_[group.front()];
    if (std::any_of(group.begin(), group.end(), [&](size_t i) { return views_[i] != view; }))
      count += group.size();
  }
  return count;
}

bool ViewsOverTime::images_differ(const Frames& group) const {
  const std::filesystem::path& first = frames_[group.front()].image;
  return std::any_of(group.begin() + 1, group.end(), [&](size_t i) {
    const std::filesystem::path& other = frames_[i].image;
    if (first.empty() || other.empty() || first == other) return false;
    return std::filesystem::file_size(first) != std::filesystem::file_size(other) ||
           read_text_file(first) != read_text_file(other);
  });
}

}  // namespace tessera
