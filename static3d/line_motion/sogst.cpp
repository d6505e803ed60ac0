// The .sogst container, version 1: the images of .sog with velocities and times of life, in groups
// of time that players cull. Acceleration and the streamed layout are not written. Source: "The
// .sogst format", revision 14 (CC BY 4.0).
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "ingest/files/atomic_file.h"
#include "kernels/base/errors.h"
#include "recon4d/model/element_edits.h"
#include "static3d/formats/sog_archive.h"
#include "static3d/formats/sog_images.h"
#include "static3d/formats/sog_layout.h"
#include "static3d/line_motion/line_formats.h"
#include "static3d/line_motion/lines.h"
#include "static3d/line_motion/model_notes.h"
#include "static3d/line_motion/seconds.h"
#include "static3d/tessera4d/windows.h"

namespace tessera {
namespace {

constexpr int kSogstVersion = 1;
constexpr double kDeviations = 3.8, kPersistent = 3;  // as the specification's encoder
constexpr double kSegmentSeconds = 0.5, kMostSegments = 65536;

/// When a line is seen, seconds.
Interval life_of(const GaussianSpans<const float>& lines, int64_t n) {
  const double time = double(*lines.at(kMeanTime, n));
  const double half = kDeviations * double(*lines.at(kLogScaleTime, n));
  return {time - half, time + half};
}

/// Lines in the order of the file: those that are seen for long, then segment by segment.
struct Segments {
  std::vector<int64_t> order;
  std::string text;  // the member of meta.json

  Segments(const GaussianSpans<const float>& lines, const TimeAxis& axis) {
    const double seconds =
        std::max(kSegmentSeconds, axis.duration / (kMostSegments / 2));  // of one segment
    std::vector<std::vector<int64_t>> members(size_t(std::ceil(axis.duration / seconds)));
    for (int64_t n = 0; n < lines.count; ++n) {
      const Interval life = life_of(lines, n);
      if (life.high - life.low > kPersistent * seconds) {
        order.push_back(n);
        continue;
      }
      const double place = (double(*lines.at(kMeanTime, n)) - axis.origin) / seconds;
      members[size_t(std::clamp(place, 0.0, double(members.size() - 1)))].push_back(n);
    }
    text = fmt::format(R"("segments":{{"duration":{},"k_sigma":{},"persistent_span_mult":{},)"
                       R"("persistent":[0,{}],"list":[)",
                       seconds, kDeviations, kPersistent, order.size());
    for (size_t s = 0; s < members.size(); ++s) {
      Interval seen{axis.origin + double(s) * seconds, axis.origin + double(s + 1) * seconds};
      if (!members[s].empty()) seen = {INFINITY, -INFINITY};
      for (const int64_t n : members[s]) {
        const Interval life = life_of(lines, n);
        seen = {std::min(seen.low, life.low), std::max(seen.high, life.high)};
      }
      const size_t first = order.size();
      order.insert(order.end(), members[s].begin(), members[s].end());
      text += fmt::format(R"({}{{"t0":{},"t1":{},"range":[{},{}]}})", s > 0 ? "," : "", seen.low,
                          seen.high, first, order.size());
    }
    text += "]}";
  }
};

/// trbf.webp: times and extents by codebooks, that of extents by their logarithms. Returns
/// "trbf":{…}.
std::string add_lives(const GaussianSpans<const float>& lines, std::vector<SogImage>& images) {
  std::vector<float> times, extents;
  for (int64_t n = 0; n < lines.count; ++n) {
    times.push_back(*lines.at(kMeanTime, n));
    extents.push_back(std::log(*lines.at(kLogScaleTime, n)));
  }
  const ScalarCodebook time_codes(times), extent_codes(extents);
  RgbaImage image = sog_image(lines.count);
  for (int64_t n = 0; n < lines.count; ++n) {
    image.at(n, 0) = time_codes.nearest(times[size_t(n)]);
    image.at(n, 1) = extent_codes.nearest(extents[size_t(n)]);
  }
  images.push_back({"trbf.webp", std::move(image)});
  std::array<float, ScalarCodebook::kEntries> seconds = extent_codes.entries();
  for (float& value : seconds) value = std::exp(value);
  return fmt::format(R"("trbf":{{"center":{{"codebook":[{}]}},"sigma":{{"codebook":[{}]}},)"
                     R"("files":["trbf.webp"]}})",
                     fmt::join(time_codes.entries(), ","), fmt::join(seconds, ","));
}

void read_lives(const SogArchive& archive, const GaussianSpans<float>& to) {
  const nlohmann::json& group = archive.object("trbf");
  const std::vector<float> times =
      archive.numbers(archive.object(group, "center"), "codebook", 256);
  const std::vector<float> extents =
      archive.numbers(archive.object(group, "sigma"), "codebook", 256);
  const RgbaImage image = archive.splat_image(group);
  for (int64_t n = 0; n < to.count; ++n) {
    *to.at(kMeanTime, n) = codebook_value(archive, times, image.at(n, 0));
    *to.at(kLogScaleTime, n) = codebook_value(archive, extents, image.at(n, 1));
  }
}

void read_velocities(const SogArchive& archive, const GaussianSpans<float>& to) {
  const nlohmann::json& group = archive.object("motion");
  if (archive.file_count(group) < 2) archive.fail("'motion' names too few files");
  read_planes(archive, "motion", group, archive.numbers(group, "mins", 3),
              archive.numbers(group, "maxs", 3), 3, [&](int64_t n, int k, double value) {
                to.at(kVelocity, n)[k] = float(sog_exponential(value));
              });
}

}  // namespace

int64_t save_sogst(const std::filesystem::path& path, const GaussianModel& model, double fps) {
  const int degree = drawn_degree(model) > 0 ? kMaxShDegree : 0;
  const TimeAxis& axis = model.time_axis;
  const GaussianSet all = lines_of(model, degree, kLongLife);
  GaussianSet lines = sog_order(path, all);
  to_seconds(axis, lines);
  const Segments segments(std::as_const(lines).values(), axis);
  const GaussianSet ordered = select_elements(lines, segments.order);
  const GaussianSpans<const float> from = ordered.values();
  const auto speed = [&](int64_t n, int k) {
    return sog_logarithm(double(from.at(kVelocity, n)[k]));
  };
  const SogRange speeds = SogRange(from.count, 3, speed).about_zero();
  std::vector<SogImage> images;
  std::string meta = fmt::format(
      R"({{"version":{},"format":"sogst","asset":{{"generator":"tessera","tessera":{}}},"count":{},)"
      R"("time":{{"min":{},"max":{},"fps":{}}},)",
      kSogstVersion, nlohmann::json(notes_of(model)).dump(), from.count, axis.origin,
      axis.origin + axis.duration, fps > 0 ? fps : kUnstatedRate);
  meta += add_means(from, images) + "," + add_shapes_and_colours(from, images);
  const std::string files = add_planes("motion", from.count, speeds, speed, images);
  meta += fmt::format(R"(,"motion":{{"degree":1,{},{}}},)", speeds.text(), files);
  meta += add_lives(from, images);
  meta += add_harmonics(from, degree, images);
  write_text_file(path, sog_archive(meta + "," + segments.text + "}", images));
  return all.count() - ordered.count();
}

LineFile load_sogst(const std::filesystem::path& path, const SogArchive& archive) {
  if (archive.meta().value("version", nlohmann::json()) != kSogstVersion)
    archive.fail("its meta.json is not of version 1 of .sogst");
  const nlohmann::json& time = archive.object("time");
  const double origin = archive.number(time, "min");
  const TimeAxis axis{origin, archive.number(time, "max") - origin};
  const int degree = degree_of(archive);
  GaussianSet lines(SetForm::kVelocity, sh_coefficients(degree));
  lines.resize(archive.count());
  read_splats_of(archive, degree, lines.values());
  read_lives(archive, lines.values());
  read_velocities(archive, lines.values());
  from_seconds(path.string(), axis, lines);
  LineFile file{model_of_lines(lines, axis), {}};
  take_notes(notes_in(archive.meta().value("asset", nlohmann::json())), path.string(), file.model);
  file.model.time_axis = axis;
  if (archive.has("accel"))
    file.warnings.push_back(
        fmt::format("{}: its accelerations are not read; motion is along lines", path.string()));
  return file;
}

}  // namespace tessera
