// Keys and values of the manifest; every value is checked before it is used.
#include "static3d/tessera4d/manifest.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "kernels/base/errors.h"
#include "kernels/math/eigen3.h"
#include "kernels/math/ewa.h"
#include "kernels/math/node_pose.h"
#include "kernels/math/splat.h"
#include "static3d/tessera4d/node_streams.h"

namespace tessera {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr uint64_t kMost = uint64_t{1} << 40;         // bytes
constexpr int64_t kMostGaussians = int64_t{1} << 28;  // of a block
constexpr const char* kTypeNames[] = {"u8", "u16", "u24", "u32", "f32"};

/// One object of the manifest, read with errors that name it.
class Reading {
 public:
  Reading(const json& object, const fs::path& path, std::string what)
      : object_(object), path_(path), what_(std::move(what)) {
    if (!object.is_object()) fail("is no object");
  }

  [[noreturn]] void fail(const std::string& wrong) const {
    throw InputError(
        fmt::format("{}: {} {}; fetch or export it again", path_.string(), what_, wrong));
  }
  const json& at(const char* key) const {
    const auto found = object_.find(key);
    if (found == object_.end()) fail(fmt::format("has no '{}'", key));
    return *found;
  }
  bool has(const char* key) const { return object_.contains(key) && !object_[key].is_null(); }
  double number(const char* key) const { return number_of(at(key), key); }
  double number_or(const char* key, double otherwise) const {
    return has(key) ? number(key) : otherwise;
  }
  uint64_t whole(const char* key, uint64_t most) const {
    const json& value = at(key);
    if (!value.is_number_unsigned() || value.get<uint64_t>() > most)
      fail(fmt::format("has '{}' {}, expected a whole number up to {}", key, shown(value), most));
    return value.get<uint64_t>();
  }
  std::string text(const char* key) const {
    const json& value = at(key);
    if (!value.is_string()) fail(fmt::format("has a '{}' that is no text", key));
    return value.get<std::string>();
  }
  bool flag_or(const char* key, bool otherwise) const {
    if (!has(key)) return otherwise;
    if (!at(key).is_boolean()) fail(fmt::format("has a '{}' that is neither true nor false", key));
    return at(key).get<bool>();
  }
  std::vector<double> numbers(const char* key, size_t count) const {
    const json& list = at(key);
    if (!list.is_array() || list.size() != count)
      fail(fmt::format("has '{}' {}, expected {} numbers", key, shown(list), count));
    std::vector<double> values;
    for (const json& value : list) values.push_back(number_of(value, key));
    return values;
  }
  Interval interval(const char* key) const {
    const std::vector<double> ends = numbers(key, 2);
    return {ends[0], ends[1]};
  }
  const json& list(const char* key) const {
    if (!at(key).is_array()) fail(fmt::format("has a '{}' that is no list", key));
    return at(key);
  }
  const fs::path& path() const { return path_; }

 private:
  static std::string shown(const json& value) { return value.dump().substr(0, 40); }
  double number_of(const json& value, const char* key) const {
    if (!value.is_number() || !std::isfinite(value.get<double>()))
      fail(fmt::format("has '{}' {}, expected a finite number", key, shown(value)));
    return value.get<double>();
  }

  const json& object_;
  const fs::path& path_;
  std::string what_;
};

json list_of(const Interval& interval) {
  return {interval.low, interval.high};
}

json to_json(const StreamInfo& stream) {
  json out = {{"name", stream.name},
              {"type", kTypeNames[int(stream.type)]},
              {"components", stream.components},
              {"count", stream.count},
              {"codec", stream.gzip ? "gzip" : "none"},
              {"offset", stream.offset},
              {"bytes", stream.bytes}};
  if (!stream.scale.empty()) {
    out["scale"] = stream.scale;
    out["bias"] = stream.bias;
  }
  if (stream.delta) out["delta"] = true;
  return out;
}

json to_json(const BlockInfo& block) {
  json out = {{"kind", block.moving      ? "dynamic"
                       : block.nodes > 0 ? "canonical"
                                         : "static"},
              {"bytes", block.bytes},
              {"crc32", block.crc32},
              {"visible", list_of(block.visible)},
              {"level", block.level},
              {"segment", list_of(block.segment)},
              {"count", block.count}};
  if (block.nodes > 0) {
    out["nodes"] = block.nodes;
    out["knots"] = block.knots;
  }
  if (block.file.empty())
    out["offset"] = block.offset;
  else
    out["file"] = block.file;
  for (const StreamInfo& stream : block.streams) out["streams"].push_back(to_json(stream));
  return out;
}

/// Streams that this version reads; others are for newer readers.
bool is_known(const std::string& name) {
  constexpr const char* kNames[] = {"position",
                                    "rotation",
                                    "log_scale",
                                    "opacity",
                                    "colour",
                                    "sh1",
                                    "sh2",
                                    "sh3",
                                    "velocity",
                                    "time_mean",
                                    "log_time_scale",
                                    "opacity_logit",
                                    "rotation_largest",
                                    "node",
                                    "node_weight",
                                    "node_logit",
                                    "node_position",
                                    "node_translation",
                                    "node_rotation",
                                    "node_log_radius"};
  return std::find(std::begin(kNames), std::end(kNames), name) != std::end(kNames);
}

StreamInfo stream_from(const json& object, const BlockInfo& block, const fs::path& path) {
  const Reading reading(object, path, "a stream");
  StreamInfo stream;
  stream.name = reading.text("name");
  const std::string type = reading.text("type"), codec = reading.text("codec");
  const auto known = std::find(std::begin(kTypeNames), std::end(kTypeNames), type);
  if (known == std::end(kTypeNames) || (codec != "gzip" && codec != "none"))
    reading.fail(fmt::format("'{}' has type '{}' and codec '{}', which this version cannot read",
                             stream.name, type, codec));
  stream.type = StreamType(known - std::begin(kTypeNames));
  stream.gzip = codec == "gzip";
  constexpr uint64_t kMostComponents = 64;
  stream.components = int(reading.whole("components", kMostComponents));
  const int64_t rows = node_rows(stream.name, block.nodes, block.knots);
  stream.count = int64_t(reading.whole("count", uint64_t(rows > 0 ? rows : block.count)));
  stream.delta = reading.flag_or("delta", false);
  stream.offset = reading.whole("offset", block.bytes);
  stream.bytes = reading.whole("bytes", block.bytes - stream.offset);
  if (stream.type != StreamType::kF32) {
    stream.scale = reading.numbers("scale", size_t(stream.components));
    stream.bias = reading.numbers("bias", size_t(stream.components));
  }
  return stream;
}

/// A name inside the folder, not a way out of it.
std::string plain_name(const Reading& block) {
  const std::string name = block.text("file");
  if (name.empty() || name.find_first_of("/\\") != std::string::npos || name == "..")
    block.fail(fmt::format("has file '{}', expected a plain name", name));
  return name;
}

BlockInfo block_from(const json& object, uint64_t version, const fs::path& path) {
  const Reading reading(object, path, "a block");
  BlockInfo block;
  const std::string kind = reading.text("kind");
  const bool is_canonical = kind == "canonical" && version >= kTessera4dNodesVersion;
  if (kind != "static" && kind != "dynamic" && !is_canonical)
    reading.fail(fmt::format("is of kind '{}', expected static or dynamic", kind));
  block.moving = kind == "dynamic";
  if (is_canonical) {
    block.nodes = int64_t(reading.whole("nodes", kMaxNodes));
    block.knots = int(reading.whole("knots", kMaxKnots));
    if (block.nodes == 0 || block.knots < kSplineOrder)
      reading.fail(
          fmt::format("has {} motion nodes with {} control points", block.nodes, block.knots));
  }
  if (reading.has("file"))
    block.file = plain_name(reading);
  else
    block.offset = reading.whole("offset", kMost);
  block.bytes = reading.whole("bytes", kMost);
  block.crc32 = uint32_t(reading.whole("crc32", UINT32_MAX));
  block.visible = reading.interval("visible");
  block.count = int64_t(reading.whole("count", uint64_t(kMostGaussians)));
  for (const json& stream : reading.list("streams"))
    if (is_known(Reading(stream, path, "a stream").text("name")))
      block.streams.push_back(stream_from(stream, block, path));
  return block;
}

void read_splat(const Reading& splat, GaussianModel& rules) {
  rules.drawing.filter_2d = splat.flag_or("compensated", false);
  rules.drawing.truncation_sigma = splat.number_or("cutoff_sigma", kTruncationSigma);
  rules.drawing.truncation_by_falloff = splat.number_or("cutoff_falloff", 0) > 0;
  rules.drawing.near_plane = splat.number_or("near", rules.drawing.near_plane);
  rules.drawing.far_plane = splat.number_or("far", rules.drawing.far_plane);
  if (const std::string wrong = wrong_rule(rules.drawing); !wrong.empty())
    splat.fail(fmt::format("cannot be drawn: {}", wrong));
}

void read_world(const Reading& file, GaussianModel& rules) {
  if (!file.has("prepared_from_source")) return;
  const std::vector<double> stored = file.numbers("prepared_from_source", kSimilarityNumbers);
  SimilarityNumbers numbers{};
  std::copy(stored.begin(), stored.end(), numbers.begin());
  rules.prepared_from_source = similarity_from_numbers(numbers);
  if (!(rules.prepared_from_source.scale > 0)) file.fail("has a world of no size");
}

}  // namespace

void check_tessera4d_version(const fs::path& path, uint64_t version) {
  if (version >= kTessera4dVersion && version <= kTessera4dNodesVersion) return;
  throw InputError(
      fmt::format("{}: a Tessera 4D file of version {}, this program reads up to {}; use a newer "
                  "one",
                  path.string(), version, kTessera4dNodesVersion));
}

int bytes_of(StreamType type) {
  switch (type) {
    case StreamType::kU8:
      return 1;
    case StreamType::kU16:
      return 2;
    case StreamType::kU24:
      return 3;
    default:
      return 4;
  }
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
  if (!rules.prepared_from_source.is_identity())
    out["prepared_from_source"] = similarity_numbers(rules.prepared_from_source);
  if (!manifest.audio.empty()) out["audio"] = manifest.audio;
  for (const PlayerCamera& camera : manifest.cameras) out["cameras"].push_back(camera_json(camera));
  if (manifest.canonical() > 0) out["gaussians"]["canonical"] = manifest.canonical();
  for (const BlockInfo& block : manifest.blocks) out["blocks"].push_back(to_json(block));
  return out;
}

Tessera4dManifest manifest_from(const json& object, const fs::path& path, GaussianModel& rules) {
  const Reading file(object, path, "its manifest");
  if (file.text("format") != kTessera4dFormat)
    throw InputError(fmt::format("{}: format '{}', expected '{}'", path.string(),
                                 file.text("format"), kTessera4dFormat));
  const uint64_t version = file.whole("version", UINT32_MAX);
  check_tessera4d_version(path, version);
  Tessera4dManifest manifest;
  manifest.generator = file.has("generator") ? file.text("generator") : "";
  const Reading time(file.at("time"), path, "its time");
  rules.time_axis = {time.number("origin"), time.number("duration")};
  if (!(rules.time_axis.duration > 0)) time.fail("has no duration");
  manifest.fps = time.number_or("fps", 0);
  rules.drawing.sh_degree = int(file.whole("sh_degree", kMaxShDegree));
  const std::vector<double> background = file.numbers("background", 3);
  for (size_t k = 0; k < 3; ++k)
    rules.background[k] = uint8_t(std::clamp(background[k], 0.0, 255.0));
  read_splat(Reading(file.at("splat"), path, "its splat"), rules);
  read_world(file, rules);
  rules.train_scale = file.number_or("train_scale", 1);
  if (!(rules.train_scale > 0)) file.fail("has a train_scale that is not positive");
  const std::string anchor = file.text("anchor");
  if (anchor != "clip" && anchor != "mean_time")
    file.fail(fmt::format("has anchor '{}', expected clip or mean_time", anchor));
  manifest.anchor_in_clip = anchor == "clip";
  manifest.lossless = file.flag_or("lossless", false);
  for (const json& block : file.list("blocks"))
    manifest.blocks.push_back(block_from(block, version, path));
  if (std::count_if(manifest.blocks.begin(), manifest.blocks.end(),
                    [](const BlockInfo& block) { return block.nodes > 0; }) > 1)
    file.fail("has more than one canonical block");
  return manifest;
}

}  // namespace tessera
