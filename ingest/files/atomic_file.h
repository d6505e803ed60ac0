// Writes whole files or none: the bytes go to a temporary file beside the target, which is
// synchronised and renamed. A failure is classified as an error of the path (InputError) or of the
// machine (WriteError).
#pragma once
#include <cstdio>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace tessera {

/// What had to be written could not be: the disk is full or broken. The message names the file,
/// what the system reported and the remedy, in one line. Exit code 1.
class WriteError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Whether errno `reason` is about the given path (no permission, not a folder, …) and not about
/// the machine (no space, an input/output error).
bool path_is_at_fault(int reason);

/// Errors: always: InputError where the path is at fault, else WriteError; the message names the
/// path, the reason (errno) and the remedy.
[[noreturn]] void fail_to_write(const std::filesystem::path& path, int reason);

/// A file that becomes visible under its name only on `commit`; a destroyed one leaves no trace
/// and the previous file intact. Errors (path and reason named): InputError: the folder cannot be
/// created or written; WriteError: the disk is full.
class AtomicFile {
 public:
  explicit AtomicFile(std::filesystem::path target);
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;
  ~AtomicFile();

  void write(const void* bytes, size_t count);
  void write(std::string_view text) { write(text.data(), text.size()); }
  /// All bytes are on the disk: `commit` needs no more room. Errors: as the constructor.
  void sync();
  void commit();

  /// Where the bytes go until `commit`, for libraries that require a path or FILE.
  const std::filesystem::path& temporary_path() const { return temporary_; }
  std::FILE* file() { return file_; }

 private:
  std::filesystem::path target_, temporary_;
  std::FILE* file_ = nullptr;
};

/// Writes `text` as the whole of `path`, atomically.
void write_text_file(const std::filesystem::path& path, std::string_view text);
/// The same for several files that belong together: none is replaced before all are on the disk.
void write_together(const std::vector<std::pair<std::filesystem::path, std::string>>& texts);
/// The whole of `path`. Errors: InputError when it is missing or unreadable.
std::string read_text_file(const std::filesystem::path& path);
/// The same of a text that any system wrote: as UTF-8 without a byte-order mark, with \n at the
/// ends of lines.
std::string read_plain_text(const std::filesystem::path& path);
std::string plain_text(std::string bytes);
/// Removes parts of files in `folder` that killed programs have left; the caller is its only
/// writer.
void remove_partial_files(const std::filesystem::path& folder);
/// Creates a folder and its parents. Errors: InputError or WriteError with the reason.
void make_folder(const std::filesystem::path& path);

}  // namespace tessera
