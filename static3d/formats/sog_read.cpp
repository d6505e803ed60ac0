// Reads .sog of PlayCanvas, version 2, from one archive whose entries are stored. Version 1 and
// folders of single images are not read. Source: formats 1.6 (PlayCanvas, "The SOG Format"),
// written from its layout.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "ingest/files/atomic_file.h"
#include "ingest/files/json_file.h"
#include "ingest/files/stored_zip.h"
#include "kernels/base/errors.h"
#include "static3d/formats/lossless_webp.h"
#include "static3d/formats/sog_layout.h"
#include "static3d/formats/splat_formats.h"

namespace tessera {
namespace {

using nlohmann::json;

constexpr int64_t kSplatsPerByte = 128;  // more than any file of trained splats has
constexpr int64_t kSparePixels = 1 << 16;

/// The entries of an archive and meta.json, with checks of what is looked up.
class SogArchive {
 public:
  SogArchive(std::string_view file, std::filesystem::path path)
      : path_(std::move(path)), contents_(zip_contents(file, path_)) {
    const auto meta = contents_.find(kSogMeta);
    if (meta == contents_.end()) fail("it has no meta.json at its root");
    meta_ = parse_json(std::string(meta->second), path_);
    if (!meta_.is_object() || !meta_.contains("version") || meta_["version"] != kSogVersion)
      fail("its meta.json is not of version 2");
    count_ = whole_number(meta_, "count", kSplatsPerByte * int64_t(file.size()) + kSparePixels);
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(fmt::format("{}: {}; convert it with splat-transform, or export it again",
                                 path_.string(), what));
  }
  int64_t count() const { return count_; }
  bool has(const char* key) const { return meta_.contains(key); }
  const json& object(const char* key) const {
    const auto found = meta_.find(key);
    if (found == meta_.end() || !found->is_object())
      fail(fmt::format("its meta.json has no object '{}'", key));
    return *found;
  }
  int64_t whole_number(const json& object, const char* key, int64_t most) const {
    const auto found = object.find(key);
    if (found == object.end() || !found->is_number_unsigned() ||
        found->get<uint64_t>() > uint64_t(most))
      fail(fmt::format("'{}' of its meta.json is no number of 0 to {}", key, most));
    return found->get<int64_t>();
  }
  std::vector<float> numbers(const json& object, const char* key, size_t most) const {
    const auto found = object.find(key);
    const bool is_list = found != object.end() && found->is_array() && !found->empty();
    if (!is_list || found->size() > most ||
        !std::all_of(found->begin(), found->end(), [](const json& x) { return x.is_number(); }))
      fail(fmt::format("'{}' of its meta.json is no list of 1 to {} numbers", key, most));
    return found->get<std::vector<float>>();
  }
  /// The image of files[index] of an object.
  RgbaImage image(const char* key, size_t index, int64_t most_pixels) const {
    const json& files = object(key).contains("files") ? object(key)["files"] : json();
    if (!files.is_array() || files.size() <= index || !files[index].is_string())
      fail(fmt::format("'{}' of its meta.json names too few files", key));
    const auto name = files[index].get<std::string>();
    const auto found = contents_.find(name);
    if (found == contents_.end()) fail(fmt::format("it has no file '{}'", name));
    return decode_webp(found->second, most_pixels, path_, name);
  }
  /// An image with a pixel for each splat.
  RgbaImage splat_image(const char* key, size_t index = 0) const {
    RgbaImage image = this->image(key, index, 4 * count_ + kSparePixels);
    if (image.pixels() < count_)
      fail(
          fmt::format("an image of '{}' has {} pixels for {} splats", key, image.pixels(), count_));
    return image;
  }

 private:
  std::filesystem::path path_;
  std::map<std::string, std::string_view> contents_;
  json meta_;
  int64_t count_ = 0;
};

float codebook_value(const SogArchive& archive, const std::vector<float>& codebook, uint8_t i) {
  if (i >= codebook.size())
    archive.fail(fmt::format("an index is {}, its codebook has {} entries", i, codebook.size()));
  return codebook[i];
}

void read_means(const SogArchive& archive, const GaussianSpans<float>& to) {
  const RgbaImage low = archive.splat_image("means", 0), high = archive.splat_image("means", 1);
  const std::vector<float> from = archive.numbers(archive.object("means"), "mins", 3);
  const std::vector<float> end = archive.numbers(archive.object("means"), "maxs", 3);
  if (from.size() != 3 || end.size() != 3) archive.fail("a range of 'means' is not of 3 numbers");
  for (int64_t n = 0; n < to.count; ++n)
    for (int k = 0; k < 3; ++k) {
      const double t = (low.at(n, k) + 256 * high.at(n, k)) / double(kSogSteps);
      const double a = double(from[size_t(k)]), b = double(end[size_t(k)]);
      to.at(kMean, n)[k] = float(sog_exponential(a + t * (b - a)));
    }
}

void read_rotations(const SogArchive& archive, const GaussianSpans<float>& to) {
  const RgbaImage image = archive.splat_image("quats");
  for (int64_t n = 0; n < to.count; ++n) {
    const std::array<uint8_t, 4> bytes{image.at(n, 0), image.at(n, 1), image.at(n, 2),
                                       image.at(n, 3)};
    if (bytes[3] < kSogLargest)
      archive.fail(fmt::format("the alpha of a quaternion is {}, expected 252 to 255", bytes[3]));
    sog_quaternion_of(bytes, to.at(kRotation, n));
  }
}

void read_scales_and_colours(const SogArchive& archive, const GaussianSpans<float>& to) {
  const RgbaImage scales = archive.splat_image("scales"), colours = archive.splat_image("sh0");
  const std::vector<float> scale_codes = archive.numbers(archive.object("scales"), "codebook", 256);
  const std::vector<float> colour_codes = archive.numbers(archive.object("sh0"), "codebook", 256);
  for (int64_t n = 0; n < to.count; ++n) {
    for (int k = 0; k < 3; ++k) {
      to.at(kLogScale, n)[k] = codebook_value(archive, scale_codes, scales.at(n, k));
      to.at(kSh, n)[k] = codebook_value(archive, colour_codes, colours.at(n, k));
    }
    *to.at(kOpacityLogit, n) = logit_of_byte(colours.at(n, 3));
  }
}

int degree_of(const SogArchive& archive) {
  if (!archive.has("shN")) return 0;
  return int(archive.whole_number(archive.object("shN"), "bands", kMaxShDegree));
}

void read_harmonics(const SogArchive& archive, int rest, const GaussianSpans<float>& to) {
  const json& meta = archive.object("shN");
  const int64_t count = archive.whole_number(meta, "count", kSogMostEntries);
  const int64_t rows = (count + kSogEntriesPerRow - 1) / kSogEntriesPerRow;
  const RgbaImage entries =
      archive.image("shN", 0, std::max<int64_t>(rows, 4) * kSogEntriesPerRow * rest);
  if (entries.width != kSogEntriesPerRow * rest || entries.height < rows)
    archive.fail(fmt::format("its palette has {} x {} pixels, expected {} x {}", entries.width,
                             entries.height, kSogEntriesPerRow * rest, rows));
  const RgbaImage labels = archive.splat_image("shN", 1);
  const std::vector<float> codebook = archive.numbers(meta, "codebook", 256);
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

SplatFile load_sog(const std::filesystem::path& path) {
  check_webp(path);
  const std::string file = read_text_file(path);
  const SogArchive archive(file, path);
  const int degree = degree_of(archive);
  SplatFile result;
  result.set = GaussianSet(SetForm::kStatic, sh_coefficients(degree));
  result.set.resize(archive.count());
  const GaussianSpans<float> to = result.set.values();
  read_means(archive, to);
  read_rotations(archive, to);
  read_scales_and_colours(archive, to);
  if (degree > 0) read_harmonics(archive, sh_coefficients(degree) - 1, to);
  return result;
}

}  // namespace tessera
