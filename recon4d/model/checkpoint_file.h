// The bytes of a checkpoint, read and written in sequence without a second copy of an array in
// memory. Layout, little-endian: "TESSCKPT", u32 version, u32 CRC-32 of the header, u64 header
// bytes, the header, the arrays, u32 CRC-32 of the arrays.
#pragma once
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "ingest/files/atomic_file.h"
#include "kernels/base/errors.h"

namespace tessera {

/// The file was read, but it is no checkpoint, of another version, truncated, damaged, or of
/// another scene or training.
class CheckpointRefused : public InputError {
 public:
  using InputError::InputError;
};

/// Throws CheckpointRefused.
[[noreturn]] void refuse_checkpoint(const std::filesystem::path& path, const std::string& why);

class CheckpointWriter {
 public:
  /// Errors of all three: as AtomicFile.
  CheckpointWriter(const std::filesystem::path& path, std::string_view header);
  void write(const void* bytes, size_t count);
  /// Until then the previous file stays.
  void commit();

 private:
  AtomicFile file_;
  uint32_t sum_ = 0;
};

class CheckpointReader {
 public:
  /// Reads the header alone. Errors of this and of all that reads: as
  /// refuse_checkpoint; InputError: the file cannot be read.
  explicit CheckpointReader(const std::filesystem::path& path);

  const std::filesystem::path& path() const { return path_; }
  /// As it was written: its checksum fits.
  const std::string& header() const { return header_; }
  /// Bytes of the file, and of the arrays in it.
  uint64_t bytes() const { return bytes_; }
  uint64_t array_bytes() const { return array_bytes_; }
  /// The next bytes of the arrays.
  void read(void* to, size_t count);
  /// After the last of them: whether all were as they were written.
  void check_sum();

 private:
  void fill(void* to, size_t count);

  std::filesystem::path path_;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;
  std::string header_;
  uint64_t bytes_ = 0, array_bytes_ = 0;
  uint32_t sum_ = 0;
};

}  // namespace tessera
