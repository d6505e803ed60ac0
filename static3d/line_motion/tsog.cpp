// Files .tsog: version 4 of Xiaomi's encoding with Playback Profile 1, continuous: the images of
// .sog with velocities, and times and extents of life in 16 bits, all in normalised time. Source:
// "TSOG Playback Profile 1", specification 1.0.1, of OpsiClear-4DGS.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ingest/files/atomic_file.h"
#include "kernels/base/errors.h"
#include "static3d/formats/sog_archive.h"
#include "static3d/formats/sog_images.h"
#include "static3d/line_motion/line_formats.h"
#include "static3d/line_motion/lines.h"
#include "static3d/line_motion/model_notes.h"

namespace tessera {
namespace {

using nlohmann::json;

constexpr int kTsogVersion = 4;
constexpr const char* kProfile = "org.opsiclear.tsog-playback";
constexpr int kProfileVersion = 1;
/// Normalised time: 0.2 % of opacity is lost at both ends of the clip, and the linear range of
/// extents is still fine for those of a frame.
constexpr double kStillExtent = 8;

void check_kind(const SogArchive& archive) {
  const json& meta = archive.meta();
  if (meta.value("version", json()) != kTsogVersion)
    archive.fail("its meta.json is not of version 4 of .tsog");
  if (!archive.has("profile")) return;  // older files are read by the same rules
  const json& profile = archive.object("profile");
  if (profile.value("id", json()) != kProfile ||
      profile.value("version", json()) != kProfileVersion)
    archive.fail("its profile is not version 1 of org.opsiclear.tsog-playback");
}

/// From 0 to the end of the clip by the rules of the profile, section 8.
TimeAxis axis_of(const SogArchive& archive) {
  const json none = json::object();
  const json& playback = archive.has("playback") ? archive.object("playback") : none;
  if (playback.contains("duration")) return {0, archive.number(playback, "duration")};
  double fps = kUnstatedRate;
  if (archive.has("fps")) fps = archive.number(archive.meta(), "fps");
  if (playback.contains("fps")) fps = archive.number(playback, "fps");
  return {0, (kUnstatedFrames - 1) / fps, false};
}

/// A list of three numbers in a list of one.
std::vector<float> first_order(const SogArchive& archive, const json& group, const char* key) {
  const auto found = group.find(key);
  if (found == group.end() || !found->is_array() || found->size() != 1)
    archive.fail("'temporal.means' of its meta.json is not of the first order");
  return archive.numbers({{key, (*found)[0]}}, key, 3);
}

void read_motion(const SogArchive& archive, const GaussianSpans<float>& to) {
  std::fill_n(to.group[kVelocity].data, to.group[kVelocity].size, 0.0f);
  if (!archive.has("temporal")) return;
  const json& temporal = archive.object("temporal");
  for (const auto& [name, group] : temporal.items())
    if (name != "means") archive.fail(fmt::format("'temporal.{}' is not read", name));
  if (!temporal.contains("means")) return;
  const json& group = archive.object(temporal, "means");
  read_planes(archive, "temporal.means", group, first_order(archive, group, "mins"),
              first_order(archive, group, "maxs"), 3,
              [&](int64_t n, int k, double value) { to.at(kVelocity, n)[k] = float(value); });
}

/// Without a timeline all stand still.
void read_timeline(const SogArchive& archive, const GaussianSpans<float>& to) {
  if (!archive.has("timeline")) {
    for (int64_t n = 0; n < to.count; ++n) {
      *to.at(kMeanTime, n) = 0.5f;
      *to.at(kLogScaleTime, n) = float(std::log(kLongLife));
    }
    return;
  }
  const json& group = archive.object("timeline");
  if (archive.whole_number(group, "type", 9) != 1)
    archive.fail(
        "its timeline is not continuous (type 1); frames that are shown one by one are "
        "not read");
  if (archive.file_count(group) < 2) archive.fail("'timeline' names too few files");
  read_planes(archive, "timeline", group, archive.numbers(group, "mins", 2),
              archive.numbers(group, "maxs", 2), 2, [&](int64_t n, int k, double value) {
                if (k == 1 && !(value > 0)) archive.fail("a temporal deviation is not above 0");
                *to.at(k == 0 ? kMeanTime : kLogScaleTime, n) =
                    float(k == 0 ? value : std::log(value));
              });
}

}  // namespace

int64_t save_tsog(const std::filesystem::path& path, const GaussianModel& model, double fps) {
  const int degree = drawn_degree(model);
  const GaussianSet all = lines_of(model, degree, kStillExtent);
  const GaussianSet lines = sog_order(path, all);
  const GaussianSpans<const float> from = lines.values();
  if (from.count == 0)
    throw InputError(
        fmt::format("{}: .tsog holds at least one Gaussian, there is none", path.string()));
  const auto life = [&](int64_t n, int k) {
    if (k == 0) return double(*from.at(kMeanTime, n));
    return std::min(std::exp(double(*from.at(kLogScaleTime, n))), kStillExtent);
  };
  const auto speed = [&](int64_t n, int k) { return double(from.at(kVelocity, n)[k]); };
  const SogRange extents(from.count, 2, life);
  const SogRange speeds = SogRange(from.count, 3, speed).about_zero();
  std::vector<SogImage> images;
  std::string meta = fmt::format(
      R"({{"version":{},"profile":{{"id":"{}","version":{}}},"asset":{{"generator":"tessera",)"
      R"("tessera":{}}},"count":{},)",
      kTsogVersion, kProfile, kProfileVersion, json(notes_of(model)).dump(), from.count);
  meta += add_means(from, images) + "," + add_shapes_and_colours(from, images);
  meta += add_harmonics(from, degree, images);
  const std::string times = add_planes("timeline", from.count, extents, life, images);
  meta += fmt::format(R"(,"timeline":{{"type":1,{},{}}})", extents.text(), times);
  const std::string motion = add_planes("temporal_means", from.count, speeds, speed, images);
  meta +=
      fmt::format(R"(,"temporal":{{"means":{{"mins":[[{}]],"maxs":[[{}]],{}}}}})",
                  numbers_text(speeds.low.data(), 3), numbers_text(speeds.high.data(), 3), motion);
  meta += fmt::format(R"(,"playback":{{"duration":{},"fps":{}}}}})", model.time_axis.duration,
                      fps > 0 ? fps : kUnstatedRate);
  write_text_file(path, sog_archive(std::move(meta), images));
  return all.count() - lines.count();
}

LineFile load_tsog(const std::filesystem::path& path, const SogArchive& archive) {
  check_kind(archive);
  const int degree = degree_of(archive);
  GaussianSet lines(SetForm::kVelocity, sh_coefficients(degree));
  lines.resize(archive.count());
  read_splats_of(archive, degree, lines.values());
  read_timeline(archive, lines.values());
  read_motion(archive, lines.values());
  LineFile file{model_of_lines(lines, axis_of(archive)), {}};
  take_notes(notes_in(archive.meta().value("asset", json())), path.string(), file.model);
  if (archive.has("audio"))
    file.warnings.push_back(fmt::format("{}: its sound is not read", path.string()));
  return file;
}

}  // namespace tessera
