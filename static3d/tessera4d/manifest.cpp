// Keys and values of the manifest; every value is checked before it is used.
#include "static3d/tessera4d/manifest.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "kernels/base/errors.h"
#include "kernels/math/eigen3.h"
#include "kernels/math/ewa.h"
#include "kernels/math/splat.h"
#include "static3d/tessera4d/checked_object.h"

namespace tessera {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

void read_splat(const CheckedObject& splat, GaussianModel& rules) {
  rules.drawing.filter_2d = splat.flag_or("compensated", false);
  rules.drawing.truncation_sigma = splat.number_or("cutoff_sigma", kTruncationSigma);
  rules.drawing.truncation_by_falloff = splat.number_or("cutoff_falloff", 0) > 0;
  rules.drawing.near_plane = splat.number_or("near", rules.drawing.near_plane);
  rules.drawing.far_plane = splat.number_or("far", rules.drawing.far_plane);
  if (const std::string wrong = wrong_rule(rules.drawing); !wrong.empty())
    splat.fail(fmt::format("cannot be drawn: {}", wrong));
}

void read_world(const CheckedObject& file, GaussianModel& rules) {
  if (!file.has("prepared_from_source")) return;
  const std::vector<double> stored = file.numbers("prepared_from_source", kSimilarityNumbers);
  SimilarityNumbers numbers{};
  std::copy(stored.begin(), stored.end(), numbers.begin());
  rules.prepared_from_source = similarity_from_numbers(numbers);
  if (!(rules.prepared_from_source.scale > 0)) file.fail("has a world of no size");
}

std::vector<FileWindow> windows_from(const CheckedObject& file) {
  std::vector<FileWindow> windows;
  for (const json& object : file.list("windows")) {
    const CheckedObject window(object, file.path(), "a window");
    windows.push_back({window.interval("time"), window.interval("drawn")});
    if (!window.has("light")) continue;
    const std::vector<double> light = window.numbers("light", 3);
    std::copy(light.begin(), light.end(), windows.back().light.begin());
  }
  if (const std::string wrong = wrong_windows(windows); !wrong.empty()) file.fail(wrong);
  return windows;
}

}  // namespace

void check_tessera4d_version(const fs::path& path, uint64_t version) {
  if (version >= kTessera4dVersion && version <= kTessera4dWindowsVersion) return;
  throw InputError(
      fmt::format("{}: a Tessera 4D file of version {}, this program reads up to {}; use a newer "
                  "one",
                  path.string(), version, kTessera4dWindowsVersion));
}

int64_t Tessera4dManifest::gaussians(bool moving) const {
  int64_t sum = 0;
  for (const BlockInfo& block : blocks)
    if (block.moving == moving) sum += block.count;
  return sum;
}

int64_t Tessera4dManifest::canonical() const {
  int64_t sum = 0;
  for (const BlockInfo& block : blocks)
    if (block.nodes > 0) sum += block.count;
  return sum;
}

int64_t Tessera4dManifest::peak() const {
  std::vector<int64_t> counts(std::max<size_t>(windows.size(), 1));
  for (const BlockInfo& block : blocks)
    if (block.moving) counts[size_t(std::max(block.window, 0))] += block.count;
  return gaussians(false) + *std::max_element(counts.begin(), counts.end());
}

uint32_t Tessera4dManifest::version() const {
  if (!windows.empty()) return kTessera4dWindowsVersion;
  return canonical() > 0 ? kTessera4dNodesVersion : kTessera4dVersion;
}

json to_json(const Tessera4dManifest& manifest, const GaussianModel& rules) {
  json out = {
      {"format", kTessera4dFormat},
      {"version", manifest.version()},
      {"generator", manifest.generator},
      {"axes", "RDF"},
      {"up", manifest.up},
      {"time",
       {{"origin", rules.time_axis.origin},
        {"duration", rules.time_axis.duration},
        {"fps", manifest.fps > 0 ? json(manifest.fps) : json()}}},
      {"bounds", nullptr},
      {"gaussians",
       {{"static", manifest.gaussians(false) - manifest.canonical()},
        {"dynamic", manifest.gaussians(true)}}},
      {"sh_degree", rules.drawing.sh_degree},
      {"background", rules.background},
      {"splat", splat_json(rules)},
      {"anchor", manifest.anchor_in_clip ? "clip" : "mean_time"},
      {"lossless", manifest.lossless},
      {"dropped", {{"non_finite", manifest.non_finite}, {"never_drawn", manifest.never_drawn}}},
      {"far_outliers", manifest.far_outliers},
      {"train_scale", rules.train_scale},
      {"cameras", json::array()},
      {"blocks", json::array()}};
  if (manifest.bounds) {
    const auto& [low, high] = *manifest.bounds;
    out["bounds"] = {{"min", {low[0], low[1], low[2]}}, {"max", {high[0], high[1], high[2]}}};
  }
  if (!rules.time_axis.is_stated) out["time"]["stated"] = false;
  if (!rules.prepared_from_source.is_identity())
    out["prepared_from_source"] = similarity_numbers(rules.prepared_from_source);
  if (!manifest.audio.empty()) out["audio"] = manifest.audio;
  for (const PlayerCamera& camera : manifest.cameras) out["cameras"].push_back(camera_json(camera));
  if (manifest.canonical() > 0) out["gaussians"]["canonical"] = manifest.canonical();
  for (const FileWindow& window : manifest.windows) out["windows"].push_back(to_json(window));
  if (!manifest.windows.empty()) out["gaussians"]["peak"] = manifest.peak();
  for (const BlockInfo& block : manifest.blocks) out["blocks"].push_back(to_json(block));
  return out;
}

Tessera4dManifest manifest_from(const json& object, const fs::path& path, GaussianModel& rules) {
  const CheckedObject file(object, path, "its manifest");
  if (file.text("format") != kTessera4dFormat)
    throw InputError(fmt::format("{}: format '{}', expected '{}'", path.string(),
                                 file.text("format"), kTessera4dFormat));
  const uint64_t version = file.whole("version", UINT32_MAX);
  check_tessera4d_version(path, version);
  Tessera4dManifest manifest;
  manifest.generator = file.has("generator") ? file.text("generator") : "";
  const CheckedObject time(file.at("time"), path, "its time");
  rules.time_axis = {time.number("origin"), time.number("duration")};
  rules.time_axis.is_stated = time.flag_or("stated", true);
  if (!(rules.time_axis.duration > 0)) time.fail("has no duration");
  manifest.fps = time.number_or("fps", 0);
  rules.drawing.sh_degree = int(file.whole("sh_degree", kMaxShDegree));
  const std::vector<double> background = file.numbers("background", 3);
  for (size_t k = 0; k < 3; ++k)
    rules.background[k] = uint8_t(std::clamp(background[k], 0.0, 255.0));
  read_splat(CheckedObject(file.at("splat"), path, "its splat"), rules);
  read_world(file, rules);
  rules.train_scale = file.number_or("train_scale", 1);
  if (!(rules.train_scale > 0)) file.fail("has a train_scale that is not positive");
  const std::string anchor = file.text("anchor");
  if (anchor != "clip" && anchor != "mean_time")
    file.fail(fmt::format("has anchor '{}', expected clip or mean_time", anchor));
  manifest.anchor_in_clip = anchor == "clip";
  manifest.lossless = file.flag_or("lossless", false);
  if (version == kTessera4dWindowsVersion) manifest.windows = windows_from(file);
  for (const json& block : file.list("blocks"))
    manifest.blocks.push_back(block_from(block, version, manifest.windows.size(), path));
  if (std::count_if(manifest.blocks.begin(), manifest.blocks.end(),
                    [](const BlockInfo& block) { return block.nodes > 0; }) > 1)
    file.fail("has more than one canonical block");
  return manifest;
}

}  // namespace tessera
