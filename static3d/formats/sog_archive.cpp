// Every number and name of meta.json is checked before it is used.
#include "static3d/formats/sog_archive.h"

#include <fmt/format.h>

#include <algorithm>

#include "ingest/files/json_file.h"
#include "ingest/files/stored_zip.h"
#include "kernels/base/errors.h"
#include "kernels/math/spherical_harmonics.h"
#include "static3d/formats/sog_layout.h"

namespace tessera {
namespace {

using nlohmann::json;

constexpr int64_t kSplatsPerByte = 128;  // more than any file of trained splats has
constexpr int64_t kSparePixels = 1 << 16;

void read_rotations(const SogArchive& archive, const GaussianSpans<float>& to) {
  const RgbaImage image = archive.splat_image(archive.object("quats"));
  for (int64_t n = 0; n < to.count; ++n) {
    const std::array<uint8_t, 4> bytes{image.at(n, 0), image.at(n, 1), image.at(n, 2),
                                       image.at(n, 3)};
    if (bytes[3] < kSogLargest)
      archive.fail(fmt::format("the alpha of a quaternion is {}, expected 252 to 255", bytes[3]));
    sog_quaternion_of(bytes, to.at(kRotation, n));
  }
}

void read_scales_and_colours(const SogArchive& archive, const GaussianSpans<float>& to) {
  const json &scale_group = archive.object("scales"), &colour_group = archive.object("sh0");
  const RgbaImage scales = archive.splat_image(scale_group),
                  colours = archive.splat_image(colour_group);
  const std::vector<float> scale_codes = archive.numbers(scale_group, "codebook", 256);
  const std::vector<float> colour_codes = archive.numbers(colour_group, "codebook", 256);
  for (int64_t n = 0; n < to.count; ++n) {
    for (int k = 0; k < 3; ++k) {
      to.at(kLogScale, n)[k] = codebook_value(archive, scale_codes, scales.at(n, k));
      to.at(kSh, n)[k] = codebook_value(archive, colour_codes, colours.at(n, k));
    }
    *to.at(kOpacityLogit, n) = logit_of_byte(colours.at(n, 3));
  }
}

void read_harmonics(const SogArchive& archive, int rest, const GaussianSpans<float>& to) {
  const json& group = archive.object("shN");
  const int64_t count = archive.whole_number(group, "count", kSogMostEntries);
  const int64_t rows = (count + kSogEntriesPerRow - 1) / kSogEntriesPerRow;
  const RgbaImage entries =
      archive.image(group, 0, std::max<int64_t>(rows, 4) * kSogEntriesPerRow * rest);
  if (entries.width != kSogEntriesPerRow * rest || entries.height < rows)
    archive.fail(fmt::format("its palette has {} x {} pixels, expected {} x {}", entries.width,
                             entries.height, kSogEntriesPerRow * rest, rows));
  const RgbaImage labels = archive.splat_image(group, 1);
  const std::vector<float> codebook = archive.numbers(group, "codebook", 256);
  for (int64_t n = 0; n < to.count; ++n) {
    const int64_t label = labels.at(n, 0) + 256 * labels.at(n, 1);
    if (label >= count)
      archive.fail(fmt::format("a label is {}, its palette has {} entries", label, count));
    for (int i = 0; i < 3 * rest; ++i)
      to.at(kSh, n)[3 + i] =
          codebook_value(archive, codebook, entries.at(label * rest + i / 3, i % 3));
  }
}

}  // namespace

SogArchive::SogArchive(std::string_view file, std::filesystem::path path)
    : path_(std::move(path)), contents_(zip_contents(file, path_)) {
  const auto meta = contents_.find(kSogMeta);
  if (meta == contents_.end()) fail("it has no meta.json at its root");
  meta_ = parse_json(std::string(meta->second), path_);
  if (!meta_.is_object()) fail("its meta.json is no object");
  count_ = whole_number(meta_, "count", kSplatsPerByte * int64_t(file.size()) + kSparePixels);
}

void SogArchive::fail(const std::string& what) const {
  throw InputError(fmt::format("{}: {}; convert it with splat-transform, or export it again",
                               path_.string(), what));
}

const json& SogArchive::object(const json& in, const char* key) const {
  const auto found = in.find(key);
  if (found == in.end() || !found->is_object())
    fail(fmt::format("its meta.json has no object '{}'", key));
  return *found;
}

int64_t SogArchive::whole_number(const json& object, const char* key, int64_t most) const {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_number_unsigned() ||
      found->get<uint64_t>() > uint64_t(most))
    fail(fmt::format("'{}' of its meta.json is no number of 0 to {}", key, most));
  return found->get<int64_t>();
}

double SogArchive::number(const json& object, const char* key) const {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_number())
    fail(fmt::format("'{}' of its meta.json is no number", key));
  return found->get<double>();
}

std::vector<float> SogArchive::numbers(const json& object, const char* key, size_t most) const {
  const auto found = object.find(key);
  const bool is_list = found != object.end() && found->is_array() && !found->empty();
  if (!is_list || found->size() > most ||
      !std::all_of(found->begin(), found->end(), [](const json& x) { return x.is_number(); }))
    fail(fmt::format("'{}' of its meta.json is no list of 1 to {} numbers", key, most));
  return found->get<std::vector<float>>();
}

size_t SogArchive::file_count(const json& group) const {
  const auto files = group.find("files");
  return files != group.end() && files->is_array() ? files->size() : 0;
}

RgbaImage SogArchive::image(const json& group, size_t index, int64_t most_pixels) const {
  if (file_count(group) <= index || !group["files"][index].is_string())
    fail("a group of its meta.json names too few files");
  const auto name = group["files"][index].get<std::string>();
  const auto found = contents_.find(name);
  if (found == contents_.end()) fail(fmt::format("it has no file '{}'", name));
  return decode_webp(found->second, most_pixels, path_, name);
}

RgbaImage SogArchive::splat_image(const json& group, size_t index) const {
  RgbaImage image = this->image(group, index, 4 * count_ + kSparePixels);
  if (image.pixels() < count_)
    fail(fmt::format("the image '{}' has {} pixels for {} splats",
                     group["files"][index].get<std::string>(), image.pixels(), count_));
  return image;
}

void read_planes(const SogArchive& archive, const char* name, const json& group,
                 const std::vector<float>& low, const std::vector<float>& high, size_t channels,
                 const std::function<void(int64_t, int, double)>& store) {
  if (low.size() != channels || high.size() != channels)
    archive.fail(fmt::format("a range of '{}' is not of {} numbers", name, channels));
  const bool has_two = archive.file_count(group) > 1;
  const RgbaImage lower = archive.splat_image(group, 0);
  const RgbaImage upper = has_two ? archive.splat_image(group, 1) : RgbaImage(0, 0);
  const double steps = has_two ? kSogSteps : 255;
  for (int64_t n = 0; n < archive.count(); ++n)
    for (size_t k = 0; k < channels; ++k) {
      const int q = lower.at(n, int(k)) + (has_two ? 256 * upper.at(n, int(k)) : 0);
      const double a = double(low[k]), b = double(high[k]);
      store(n, int(k), a + q / steps * (b - a));
    }
}

float codebook_value(const SogArchive& archive, const std::vector<float>& codebook, uint8_t index) {
  if (index >= codebook.size())
    archive.fail(
        fmt::format("an index is {}, its codebook has {} entries", index, codebook.size()));
  return codebook[index];
}

void read_splats_of(const SogArchive& archive, int degree, const GaussianSpans<float>& to) {
  const json& means = archive.object("means");
  if (archive.file_count(means) < 2) archive.fail("'means' of its meta.json names too few files");
  read_planes(archive, "means", means, archive.numbers(means, "mins", 3),
              archive.numbers(means, "maxs", 3), 3, [&](int64_t n, int k, double value) {
                to.at(kMean, n)[k] = float(sog_exponential(value));
              });
  read_rotations(archive, to);
  read_scales_and_colours(archive, to);
  if (degree > 0) read_harmonics(archive, sh_coefficients(degree) - 1, to);
}

int degree_of(const SogArchive& archive) {
  if (!archive.has("shN")) return 0;
  return int(archive.whole_number(archive.object("shN"), "bands", kMaxShDegree));
}

}  // namespace tessera
