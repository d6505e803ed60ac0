// Reads the files and blocks of a Tessera 4D file into one model.
#include <fmt/format.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "ingest/files/atomic_file.h"
#include "ingest/files/bytes.h"
#include "ingest/files/json_file.h"
#include "kernels/base/errors.h"
#include "recon4d/model/element_edits.h"
#include "static3d/tessera4d/block.h"
#include "static3d/tessera4d/tessera4d.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMostPerByte = 500;     // of memory, for a byte of the file; gzip ends at 1032
constexpr uint64_t kFreeBytes = 64 << 20;  // bytes of memory, however few the file has

/// Copies the elements of `part` behind the first `first` of `whole`.
void place_elements(const GaussianSet& part, GaussianSet& whole, int64_t first) {
  const GaussianSpans<const float> from = part.values();
  const GaussianSpans<float> to = whole.values();
  for (int g = 0; g < part.groups(); ++g)
    std::copy_n(from.group[g].data, from.group[g].size,
                to.group[g].data + first * whole.width(Group(g)));
}

/// The blocks of one kind as one set; unsound Gaussians are left out and counted.
GaussianSet joined(std::vector<GaussianSet> parts, SetForm form, int coefficients,
                   int64_t& unsound) {
  int64_t count = 0;
  for (GaussianSet& part : parts) {
    const std::vector<int64_t> elements = valid_elements(part);
    unsound += part.count() - int64_t(elements.size());
    if (int64_t(elements.size()) != part.count()) part = select_elements(part, elements);
    count += part.count();
  }
  GaussianSet whole(form, coefficients);
  whole.resize(count);
  int64_t first = 0;
  for (const GaussianSet& part : parts) {
    place_elements(part, whole, first);
    first += part.count();
  }
  return whole;
}

/// Static Gaussians in front of those that nodes carry, in one canonical set.
GaussianSet with_carried(const GaussianSet& fixed, const GaussianSet& carried) {
  GaussianSet whole(SetForm::kCanonical, fixed.coefficients());
  whole.resize(fixed.count() + carried.count());
  const GaussianSpans<float> to = whole.values();
  std::fill_n(to.group[kNode].data, kBindings * fixed.count(), -1.0f);
  std::fill_n(to.group[kNodeLogit].data, kBindings * fixed.count(), 0.0f);
  place_elements(fixed, whole, 0);
  place_elements(carried, whole, fixed.count());
  return whole;
}

/// Streams of equal words pack to a thousandth, so that a small damaged file could fill the memory.
/// `gaussians`: of the blocks so far, which have so many bytes.
void check_promise(int64_t gaussians, int64_t bytes, int coefficients, const fs::path& path) {
  const GaussianSet widest(SetForm::kCanonical, coefficients);
  uint64_t scalars = 0;
  for (int g = 0; g < widest.groups(); ++g) scalars += uint64_t(widest.width(Group(g)));
  const uint64_t promised = uint64_t(gaussians) * scalars * sizeof(float);
  if (promised > kMostPerByte * uint64_t(bytes) + kFreeBytes)
    throw InputError(
        fmt::format("{}: its blocks promise {} Gaussians in {} bytes; it is damaged, fetch or "
                    "export it again",
                    path.string(), gaussians, bytes));
}

/// `block` gives the bytes of a block and the name of the file that they are in.
template <class BlockBytes>
void read_blocks(Tessera4dInput& input, const fs::path& path, BlockBytes&& block) {
  std::vector<GaussianSet> fixed, moving, carried;
  const int coefficients = sh_coefficients(input.model.drawing.sh_degree);
  int64_t gaussians = 0, packed = 0;
  for (const BlockInfo& info : input.manifest.blocks) {
    const auto& [file, bytes] = block(info);
    check_promise(gaussians += info.count, packed += int64_t(bytes.size()), coefficients, path);
    (info.moving      ? moving
     : info.nodes > 0 ? carried
                      : fixed)
        .push_back(decode_block(bytes, info, input.model.drawing.sh_degree,
                                input.manifest.anchor_in_clip, file, &input.model.nodes));
    input.bytes += int64_t(info.bytes);
  }
  int64_t unsound = 0;
  input.model.static_set = joined(std::move(fixed), SetForm::kStatic, coefficients, unsound);
  if (!carried.empty())
    input.model.static_set =
        with_carried(input.model.static_set,
                     joined(std::move(carried), SetForm::kCanonical, coefficients, unsound));
  input.model.dynamic_set = joined(std::move(moving), SetForm::kVelocity, coefficients, unsound);
  if (unsound > 0)
    input.warnings.push_back(
        fmt::format("{}: {} Gaussians that are not finite are left out", path.string(), unsound));
}

Tessera4dInput load_folder(const fs::path& folder) {
  Tessera4dInput input;
  const fs::path path = folder / kTessera4dManifest;
  input.manifest = manifest_from(read_json(path), path, input.model);
  input.bytes = int64_t(fs::file_size(path));
  std::set<std::string> names;
  read_blocks(input, path, [&](const BlockInfo& info) {
    if (info.file.empty() || !names.insert(info.file).second)
      throw InputError(fmt::format(
          "{}: a block without a 'file' of its own in a folder; export it again", path.string()));
    return std::pair(folder / info.file, read_text_file(folder / info.file));
  });
  return input;
}

/// Blocks that lay on each other would be more Gaussians than the file has bytes for.
void check_sizes(const Tessera4dManifest& manifest, uint64_t bytes, const fs::path& path) {
  uint64_t sum = 0;
  for (const BlockInfo& block : manifest.blocks) {
    if (block.bytes > bytes - sum)
      throw InputError(
          fmt::format("{}: its blocks have more than the {} bytes behind its manifest; it is cut "
                      "off, fetch or export it again",
                      path.string(), bytes));
    sum += block.bytes;
  }
}

Tessera4dInput load_single(const fs::path& path) {
  Tessera4dInput input;
  const std::string bytes = read_text_file(path);
  ByteReader reader(bytes, path);
  reader.take(kTessera4dMagic.size());
  check_tessera4d_version(path, reader.number<uint32_t>());
  const std::string_view text = reader.take(reader.number<uint32_t>());
  const nlohmann::json manifest = parse_json(std::string(text), path);
  input.manifest = manifest_from(manifest, path, input.model);
  input.bytes = int64_t(bytes.size() - reader.left());
  const std::string_view data = reader.take(reader.left());
  check_sizes(input.manifest, data.size(), path);
  read_blocks(input, path, [&](const BlockInfo& info) {
    if (info.offset > data.size() || info.bytes > data.size() - info.offset)
      throw InputError(
          fmt::format("{}: is cut off: a block of {} bytes begins at {} of {}; fetch "
                      "or export it again",
                      path.string(), info.bytes, info.offset, data.size()));
    return std::pair(path, data.substr(info.offset, info.bytes));
  });
  return input;
}

}  // namespace

bool is_tessera4d(std::string_view head) {
  return head.starts_with(kTessera4dMagic);
}

bool is_tessera4d_folder(const fs::path& folder) {
  const fs::path path = folder / kTessera4dManifest;
  if (!fs::is_regular_file(path)) return false;
  const nlohmann::json manifest = read_json(path);
  return manifest.is_object() && manifest.value("format", nlohmann::json()) == kTessera4dFormat;
}

Tessera4dInput load_tessera4d(const fs::path& path) {
  return fs::is_directory(path) ? load_folder(path) : load_single(path);
}

}  // namespace tessera
