// Preamble, header and arrays of a checkpoint through stdio, with zlib's CRC-32 of each.
#include "recon4d/model/checkpoint_file.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

constexpr uint32_t kVersion = 7;
constexpr size_t kBlock = size_t{1} << 18;  // bytes that stay in a cache between file and checksum

struct Preamble {
  char magic[8];
  uint32_t version, header_sum;
  uint64_t header_bytes;
};
static_assert(sizeof(Preamble) == 24);
constexpr char kMagic[8] = {'T', 'E', 'S', 'S', 'C', 'K', 'P', 'T'};
constexpr size_t kThroughVersion = 12;

uint32_t crc32_of(uint32_t before, const void* bytes, size_t count) {
  return uint32_t(crc32_z(before, static_cast<const Bytef*>(bytes), count));
}

[[noreturn]] void fail_to_read(const std::filesystem::path& path, int reason) {
  throw InputError(fmt::format("{}: cannot be read ({}); check the path and its permissions",
                               path.string(), std::strerror(reason)));
}

}  // namespace

void refuse_checkpoint(const std::filesystem::path& path, const std::string& why) {
  throw CheckpointRefused(fmt::format("{}: {}", path.string(), why));
}

CheckpointWriter::CheckpointWriter(const std::filesystem::path& path, std::string_view header)
    : file_(path) {
  Preamble preamble{{}, kVersion, crc32_of(0, header.data(), header.size()), header.size()};
  std::memcpy(preamble.magic, kMagic, sizeof(kMagic));
  file_.write(&preamble, sizeof(preamble));
  file_.write(header);
}

void CheckpointWriter::write(const void* bytes, size_t count) {
  const auto* from = static_cast<const char*>(bytes);
  for (size_t done = 0; done < count; done += kBlock) {
    const size_t block = std::min(kBlock, count - done);
    sum_ = crc32_of(sum_, from + done, block);
    file_.write(from + done, block);
  }
}

void CheckpointWriter::commit() {
  file_.write(&sum_, sizeof(sum_));
  file_.commit();
}

CheckpointReader::CheckpointReader(const std::filesystem::path& path)
    : path_(path), file_(std::fopen(path.c_str(), "rb"), std::fclose) {
  if (file_ == nullptr) fail_to_read(path_, errno);
  Preamble preamble{};
  const size_t bytes_read = std::fread(&preamble, 1, sizeof(preamble), file_.get());
  if (std::ferror(file_.get()) != 0) fail_to_read(path_, errno);
  if (bytes_read < sizeof(kMagic) || std::memcmp(preamble.magic, kMagic, sizeof(kMagic)) != 0)
    refuse_checkpoint(path_, "not a Tessera checkpoint (the file does not begin with TESSCKPT)");
  if (bytes_read >= kThroughVersion && preamble.version != kVersion)
    refuse_checkpoint(path_, fmt::format("checkpoint version {}, this program reads version {}; "
                                         "resume it with the version that wrote it",
                                         preamble.version, kVersion));
  std::error_code reason;
  bytes_ = std::filesystem::file_size(path_, reason);
  if (reason) fail_to_read(path_, reason.value());
  constexpr size_t kAround = sizeof(preamble) + sizeof(sum_);
  if (bytes_ < kAround || preamble.header_bytes > bytes_ - kAround)
    refuse_checkpoint(path_, "truncated checkpoint: header incomplete");
  array_bytes_ = bytes_ - kAround - preamble.header_bytes;
  header_.resize(preamble.header_bytes);
  fill(header_.data(), header_.size());
  if (crc32_of(0, header_.data(), header_.size()) != preamble.header_sum)
    refuse_checkpoint(path_, "damaged checkpoint: the checksum of its header does not match");
}

void CheckpointReader::fill(void* to, size_t count) {
  if (std::fread(to, 1, count, file_.get()) == count) return;
  if (std::ferror(file_.get()) != 0) fail_to_read(path_, errno);
  refuse_checkpoint(path_, "truncated checkpoint: it became shorter while it was read");
}

void CheckpointReader::read(void* to, size_t count) {
  auto* const into = static_cast<char*>(to);
  for (size_t done = 0; done < count; done += kBlock) {
    const size_t block = std::min(kBlock, count - done);
    fill(into + done, block);
    sum_ = crc32_of(sum_, into + done, block);
  }
}

void CheckpointReader::check_sum() {
  uint32_t stored = 0;
  fill(&stored, sizeof(stored));
  if (stored != sum_) refuse_checkpoint(path_, "damaged checkpoint: its checksum does not match");
}

}  // namespace tessera
