// Names are split into folders and file; folders that are the same in all names say nothing.
#include "ingest/prepared/camera_labels.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "ingest/images/image_names.h"

namespace tessera {
namespace {

const std::set<std::string> kCameraWords{"camera", "cam"};
const std::set<std::string> kNamingWords{"id", "idx", "index", "name", "number", "no"};

using Folders = std::vector<std::string>;

Folders folders_of(const std::string& name) {
  Folders folders;
  for (const std::filesystem::path& part : std::filesystem::path(name).parent_path())
    folders.push_back(part.string());
  return folders;
}

/// How many folders all lists begin with.
size_t common_beginning(const std::vector<Folders>& lists) {
  size_t common = lists.empty() ? 0 : lists.front().size();
  for (const Folders& list : lists) {
    const auto end = std::mismatch(list.begin(), list.end(), lists.front().begin(),
                                   lists.front().begin() + int64_t(common));
    common = size_t(end.first - list.begin());
  }
  return common;
}

/// The folders that differ, joined: "left" and "right" of left/images and right/images.
CameraLabels folder_labels(const std::vector<std::string>& names) {
  std::vector<Folders> lists;
  for (const std::string& name : names) lists.push_back(folders_of(name));
  for (int side = 0; side < 2; ++side) {
    const auto common = int64_t(common_beginning(lists));
    for (Folders& list : lists) {
      list.erase(list.begin(), list.begin() + common);
      std::reverse(list.begin(), list.end());
    }
  }
  CameraLabels labels;
  for (const Folders& list : lists) {
    std::string& label = labels.emplace_back();
    for (const std::string& folder : list) label += (label.empty() ? "" : "_") + folder;
  }
  return labels;
}

std::string file_stem(const std::string& name) {
  return name.substr(name.rfind('/') + 1);
}

std::string joined_label(const std::string& folder, const std::string& camera) {
  return folder.empty() || camera.empty() ? folder + camera : folder + "_" + camera;
}

/// The digits that the name ends with.
std::string last_number(const std::string& stem) {
  const size_t other = stem.find_last_not_of("0123456789");
  return other == std::string::npos ? stem : stem.substr(other + 1);
}

}  // namespace

std::string camera_key_of(const StatedObject& entry) {
  for (const auto& [key, value] : entry.members()) {
    if (!is_of_words(key, kCameraWords, kNamingWords)) continue;
    if (!value->is_string() && !value->is_number_integer()) continue;
    entry.take(key);
    return value->is_string() ? value->get<std::string>() : value->dump();
  }
  return "";
}

std::vector<CameraLabels> camera_labels(const std::vector<std::string>& names) {
  CameraLabels folders = folder_labels(names), before_number, both, whole, last;
  for (size_t i = 0; i < names.size(); ++i) {
    const std::string stem = file_stem(names[i]);
    const auto numbered = parse_stem(stem);
    before_number.push_back(numbered ? numbered->camera : "");
    both.push_back(joined_label(folders[i], before_number.back()));
    whole.push_back(stem);
    last.push_back(last_number(stem));
  }
  return {std::move(folders), std::move(before_number), std::move(both), std::move(whole),
          std::move(last)};
}

}  // namespace tessera
