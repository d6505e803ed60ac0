// Both rules make an assignment of all clips, which are then compared.
#include "ingest/calibration/view_matching.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>

#include "ingest/files/text_scan.h"
#include "ingest/test_views.h"

namespace tessera {
namespace {

using Assignment = std::vector<std::optional<size_t>>;
using Numbers = std::map<int64_t, std::vector<size_t>>;  // places in a list by the number

/// A stated name taken apart, `\` as `/`.
struct ViewName {
  explicit ViewName(std::string stated) {
    std::replace(stated.begin(), stated.end(), '\\', '/');
    const std::filesystem::path path = std::filesystem::path(stated).lexically_normal();
    whole = path.generic_string();
    stem = path.stem().string();
    for (const auto& folder : path.parent_path()) folders.push_back(folder.string());
  }
  std::string whole, stem;
  std::vector<std::string> folders;
};

constexpr const char* kDigits = "0123456789";

/// "cam00" of "cam00_0012"; the text itself where it does not end so.
std::string without_number(const std::string& stem) {
  const size_t last = stem.find_last_not_of(kDigits);
  if (last == std::string::npos || last + 1 == stem.size() || last == 0 ||
      std::string("_-. ").find(stem[last]) == std::string::npos)
    return stem;
  return stem.substr(0, last);
}

/// The number that a name ends with.
std::optional<int64_t> number_of(const std::string& name) {
  const size_t last = name.find_last_not_of(kDigits);
  std::string_view digits = std::string_view(name).substr(last == std::string::npos ? 0 : last + 1);
  if (digits.empty() || digits.size() > 9) return std::nullopt;
  return take_number(digits, 9);
}

/// The clips that a name may mean: one, none, or two that its parts name.
std::vector<size_t> clips_named(const ViewName& view, const std::vector<std::string>& clips) {
  const auto place = [&](const std::string& label) {
    return size_t(std::find(clips.begin(), clips.end(), label) - clips.begin());
  };
  if (const size_t whole = place(view.whole); whole < clips.size()) return {whole};
  std::vector<size_t> named;
  const auto add = [&](const std::string& label) {
    const size_t found = place(label);
    if (found < clips.size() && std::find(named.begin(), named.end(), found) == named.end())
      named.push_back(found);
  };
  add(view.stem);
  for (const std::string& folder : view.folders) add(folder);
  if (named.empty()) add(without_number(view.stem));
  return named;
}

bool have_one_pose(const std::vector<RigCamera>& cameras, const std::vector<size_t>& places) {
  return std::all_of(places.begin(), places.end(), [&](size_t place) {
    return equal_pose(cameras[place].camera, cameras[places.front()].camera);
  });
}

/// By name; `refusal` says why a name assigns nothing.
Assignment by_name(const std::vector<RigCamera>& cameras, const std::vector<std::string>& clips,
                   std::string& refusal) {
  std::vector<std::vector<size_t>> views(clips.size());
  for (size_t i = 0; i < cameras.size(); ++i) {
    const std::vector<size_t> named = clips_named(ViewName(cameras[i].name), clips);
    if (named.size() > 1) {
      refusal =
          fmt::format("'{}' names {} and {}", cameras[i].name, clips[named[0]], clips[named[1]]);
      return Assignment(clips.size());
    }
    if (!named.empty()) views[named.front()].push_back(i);
  }
  Assignment assigned;
  for (size_t c = 0; c < clips.size(); ++c) {
    if (!have_one_pose(cameras, views[c])) {
      refusal = fmt::format("its {} images of {} have different poses: a camera that moves",
                            views[c].size(), clips[c]);
      return Assignment(clips.size());
    }
    assigned.push_back(views[c].empty() ? std::nullopt : std::optional(views[c].front()));
  }
  return assigned;
}

/// Places by the number of each label; empty where one has none.
Numbers numbered(const std::vector<std::string>& labels) {
  Numbers numbers;
  for (size_t i = 0; i < labels.size(); ++i) {
    const auto number = number_of(labels[i]);
    if (!number) return {};
    numbers[*number].push_back(i);
  }
  return numbers;
}

/// One to one by the numbers of `labels`, one a camera; nothing where they are not.
std::optional<Assignment> by_number(const std::vector<RigCamera>& cameras, const Numbers& views,
                                    const Numbers& clips) {
  if (views.size() != clips.size() || clips.empty()) return std::nullopt;
  Assignment assigned(clips.size());
  for (const auto& [number, places] : clips) {
    const auto found = views.find(number);
    if (found == views.end() || places.size() != 1 || !have_one_pose(cameras, found->second))
      return std::nullopt;
    assigned[places.front()] = found->second.front();
  }
  return assigned;
}

/// The first clip to which the two assign different cameras.
std::optional<size_t> contradiction(const Assignment& one, const Assignment& other) {
  for (size_t c = 0; c < one.size(); ++c)
    if (one[c] && other[c] && *one[c] != *other[c]) return c;
  return std::nullopt;
}

/// "; the numbers differ by 1, and an offset is not guessed", or nothing.
std::string offset_text(const Numbers& views, const Numbers& clips) {
  if (views.size() != clips.size() || clips.size() < 2) return "";
  const int64_t offset = views.begin()->first - clips.begin()->first;
  const bool shifted = std::equal(
      clips.begin(), clips.end(), views.begin(),
      [&](const auto& clip, const auto& view) { return view.first - clip.first == offset; });
  return shifted && offset != 0
             ? fmt::format("; their numbers differ by {}, and an offset is not guessed", offset)
             : "";
}

}  // namespace

MatchedViews match_views(const std::vector<RigCamera>& cameras,
                         const std::vector<std::string>& clips) {
  std::vector<std::string> names, stems, folders;
  for (const RigCamera& camera : cameras) {
    const ViewName view(camera.name);
    names.push_back(camera.name);
    stems.push_back(view.stem);
    folders.push_back(view.folders.empty() ? "" : view.folders.back());
  }
  const auto refused = [&](const std::string& reason) {
    return MatchedViews{Assignment(clips.size()),
                        fmt::format("has no camera for {}; it has {}{}", listed_names(clips),
                                    listed_names(names), reason)};
  };
  std::string refusal;
  Assignment chosen = by_name(cameras, clips, refusal);
  if (!refusal.empty()) return refused("; " + refusal);
  const Numbers of_clips = numbered(clips), of_stems = numbered(stems);
  for (const Numbers& of_views : {of_stems, numbered(folders)}) {
    const auto by_numbers = by_number(cameras, of_views, of_clips);
    if (!by_numbers) continue;
    if (const auto clip = contradiction(chosen, *by_numbers))
      return refused(fmt::format("; {} is '{}' by one rule and '{}' by another", clips[*clip],
                                 names[*chosen[*clip]], names[*(*by_numbers)[*clip]]));
    chosen = *by_numbers;
  }
  const bool any = std::any_of(chosen.begin(), chosen.end(), [](const auto& c) { return c; });
  return any ? MatchedViews{chosen, ""} : refused(offset_text(of_stems, of_clips));
}

}  // namespace tessera
