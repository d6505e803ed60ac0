// Reads the manifest and single blocks of a folder or of one file, whose ranges are checked first.
#include "static3d/tessera4d/container.h"

#include <fmt/format.h>

#include <fstream>
#include <set>

#include "ingest/files/atomic_file.h"
#include "ingest/files/bytes.h"
#include "ingest/files/json_file.h"
#include "kernels/base/errors.h"
#include "static3d/tessera4d/tessera4d.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

/// `count` bytes from `first` on; fewer where the file ends.
std::string bytes_from(const fs::path& path, uint64_t first, uint64_t count) {
  std::ifstream file(path, std::ios::binary);
  file.seekg(std::streamoff(first));
  std::string bytes(count, '\0');
  file.read(bytes.data(), std::streamsize(count));
  bytes.resize(size_t(std::max<std::streamsize>(file.gcount(), 0)));
  if (file.bad() || !file.is_open())
    throw InputError(
        fmt::format("{}: cannot be read; check the path and its permissions", path.string()));
  return bytes;
}

/// Blocks that lay on each other would be more Gaussians than the file has bytes for.
void check_ranges(const Tessera4dManifest& manifest, uint64_t bytes, const fs::path& path) {
  uint64_t sum = 0;
  for (const BlockInfo& block : manifest.blocks) {
    if (block.bytes > bytes - sum)
      throw InputError(
          fmt::format("{}: its blocks have more than the {} bytes behind its manifest; it is cut "
                      "off, fetch or export it again",
                      path.string(), bytes));
    sum += block.bytes;
    if (block.offset > bytes || block.bytes > bytes - block.offset)
      throw InputError(
          fmt::format("{}: is cut off: a block of {} bytes begins at {} of {}; fetch "
                      "or export it again",
                      path.string(), block.bytes, block.offset, bytes));
  }
}

}  // namespace

Tessera4dContainer::Tessera4dContainer(const fs::path& path)
    : path_(path), is_folder_(fs::is_directory(path)) {
  is_folder_ ? open_folder(path) : open_single();
}

void Tessera4dContainer::open_folder(const fs::path& folder) {
  path_ = folder / kTessera4dManifest;
  json_ = read_json(path_);
  manifest_ = manifest_from(json_, path_, rules_);
  first_ = fs::file_size(path_);
  std::set<std::string> names;
  for (const BlockInfo& block : manifest_.blocks)
    if (block.file.empty() || !names.insert(block.file).second)
      throw InputError(fmt::format(
          "{}: a block without a 'file' of its own in a folder; export it again", path_.string()));
}

void Tessera4dContainer::open_single() {
  constexpr uint64_t kNumbers = 2 * sizeof(uint32_t);
  const std::string head = bytes_from(path_, 0, kTessera4dMagic.size() + kNumbers);
  ByteReader reader(head, path_);
  reader.take(kTessera4dMagic.size());
  check_tessera4d_version(path_, reader.number<uint32_t>());
  const uint64_t length = reader.number<uint32_t>(), size = fs::file_size(path_);
  if (length > size - head.size())
    throw InputError(
        fmt::format("{}: has {} bytes of its manifest of {}; it is cut off, fetch or "
                    "export it again",
                    path_.string(), size - head.size(), length));
  json_ = parse_json(bytes_from(path_, head.size(), length), path_);
  manifest_ = manifest_from(json_, path_, rules_);
  first_ = head.size() + length;
  check_ranges(manifest_, size - first_, path_);
}

int64_t Tessera4dContainer::bytes() const {
  uint64_t sum = first_;
  for (const BlockInfo& block : manifest_.blocks) sum += block.bytes;
  return int64_t(sum);
}

fs::path Tessera4dContainer::file_of(const BlockInfo& block) const {
  return is_folder_ ? path_.parent_path() / block.file : path_;
}

std::string Tessera4dContainer::block(const BlockInfo& block) const {
  const fs::path file = file_of(block);
  return is_folder_ ? read_text_file(file) : bytes_from(file, first_ + block.offset, block.bytes);
}

}  // namespace tessera
