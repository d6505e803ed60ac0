// AtomicFile on stdio and rename(2); every result that may report a full disk is checked. The
// folder entry is not synchronised: after a power cut the previous file may still be there.
#include "ingest/files/atomic_file.h"

#include <fmt/format.h>
#include <unistd.h>
#include <utf8proc.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <deque>
#include <system_error>
#include <utility>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

/// A name beside `target` that no other AtomicFile of any process has.
std::filesystem::path temporary_beside(const std::filesystem::path& target) {
  static std::atomic<int64_t> counter{0};
  return target.parent_path() /
         fmt::format(".{}.{}-{}.partial", target.filename().string(), ::getpid(), counter++);
}

/// Of a text with its byte-order mark.
std::string from_utf16(const std::string& bytes) {
  const bool little = bytes[0] == '\xff';
  const auto unit = [&](size_t i) {
    const auto first = uint8_t(bytes[i]), second = uint8_t(bytes[i + 1]);
    return little ? uint32_t(first | second << 8) : uint32_t(first << 8 | second);
  };
  std::string text;
  utf8proc_uint8_t encoded[4];
  for (size_t i = 2; i + 1 < bytes.size(); i += 2) {
    uint32_t code = unit(i);
    if (code >= 0xd800 && code < 0xdc00 && i + 3 < bytes.size()) {  // a pair of surrogates
      code = 0x10000 + ((code - 0xd800) << 10) + (unit(i + 2) - 0xdc00) % 0x400;
      i += 2;
    }
    const auto length = utf8proc_encode_char(utf8proc_int32_t(code), encoded);
    text.append(reinterpret_cast<const char*>(encoded), size_t(length));
  }
  return text;
}

}  // namespace

bool path_is_at_fault(int reason) {
  constexpr std::array kOfThePath{EACCES, EPERM,  EROFS,     ENOENT,  ENOTDIR, EISDIR, ENAMETOOLONG,
                                  ELOOP,  EEXIST, ENOTEMPTY, ETXTBSY, EBUSY,   EXDEV,  EINVAL};
  return std::find(kOfThePath.begin(), kOfThePath.end(), reason) != kOfThePath.end();
}

void fail_to_write(const std::filesystem::path& path, int reason) {
  const std::string seen =
      fmt::format("{}: cannot be written ({})", path.string(), std::strerror(reason));
  if (path_is_at_fault(reason))
    throw InputError(seen + "; check the path and its permissions or choose another folder");
  throw WriteError(seen + "; free space or choose another folder");
}

AtomicFile::AtomicFile(std::filesystem::path target)
    : target_(std::move(target)), temporary_(temporary_beside(target_)) {
  if (!target_.parent_path().empty()) make_folder(target_.parent_path());
  file_ = std::fopen(temporary_.c_str(), "wbx");
  if (file_ == nullptr) fail_to_write(target_, errno);
}

AtomicFile::~AtomicFile() {
  if (file_ != nullptr) std::fclose(file_);
  std::error_code ignored;
  if (!temporary_.empty()) std::filesystem::remove(temporary_, ignored);
}

void AtomicFile::write(const void* bytes, size_t count) {
  check(file_ != nullptr, "AtomicFile::write after commit");
  if (count > 0 && std::fwrite(bytes, 1, count, file_) != count) fail_to_write(target_, errno);
}

void AtomicFile::sync() {
  check(file_ != nullptr, "AtomicFile::sync after commit");
  if (std::ferror(file_) != 0) fail_to_write(target_, EIO);
  if (std::fflush(file_) != 0 || ::fsync(::fileno(file_)) != 0) fail_to_write(target_, errno);
}

void AtomicFile::commit() {
  sync();
  std::FILE* const closing = std::exchange(file_, nullptr);
  if (std::fclose(closing) != 0) fail_to_write(target_, errno);
  if (std::rename(temporary_.c_str(), target_.c_str()) != 0) fail_to_write(target_, errno);
  temporary_.clear();
}

void write_text_file(const std::filesystem::path& path, std::string_view text) {
  AtomicFile file(path);
  file.write(text);
  file.commit();
}

void write_together(const std::vector<std::pair<std::filesystem::path, std::string>>& texts) {
  std::deque<AtomicFile> files;
  for (const auto& [path, text] : texts) {
    files.emplace_back(path);
    files.back().write(text);
    files.back().sync();
  }
  for (AtomicFile& file : files) file.commit();
}

std::string read_text_file(const std::filesystem::path& path) {
  const auto fail = [&](int reason) {
    throw InputError(fmt::format("{}: cannot be read ({}); check the path and its permissions",
                                 path.string(), std::strerror(reason)));
  };
  std::FILE* const file = std::fopen(path.c_str(), "rb");
  if (file == nullptr) fail(errno);
  std::string bytes;
  std::error_code unknown_size;
  const auto size = std::filesystem::file_size(path, unknown_size);
  if (!unknown_size) bytes.reserve(size);
  char block[1 << 16];
  for (size_t count; (count = std::fread(block, 1, sizeof block, file)) > 0;)
    bytes.append(block, count);
  const int reason = std::ferror(file) != 0 ? errno : 0;
  std::fclose(file);
  if (reason != 0) fail(reason);
  return bytes;
}

void remove_partial_files(const std::filesystem::path& folder) {
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(folder, ignored)) {
    const std::string name = entry.path().filename().string();
    if (entry.is_regular_file(ignored) && name.starts_with(".") && name.ends_with(".partial"))
      std::filesystem::remove(entry.path(), ignored);
  }
}

void make_folder(const std::filesystem::path& path) {
  std::error_code reason;
  std::filesystem::create_directories(path, reason);
  if (!reason && !std::filesystem::is_directory(path, reason))
    reason = std::make_error_code(std::errc::not_a_directory);
  if (!reason) return;
  if (!path_is_at_fault(reason.value())) fail_to_write(path, reason.value());
  throw InputError(fmt::format("{}: folder cannot be created ({}); choose another place",
                               path.string(), reason.message()));
}

std::string read_plain_text(const std::filesystem::path& path) {
  return plain_text(read_text_file(path));
}

std::string plain_text(std::string bytes) {
  if (bytes.starts_with("\xff\xfe") || bytes.starts_with("\xfe\xff")) bytes = from_utf16(bytes);
  if (bytes.starts_with("\xef\xbb\xbf")) bytes.erase(0, 3);
  if (bytes.find('\r') == std::string::npos) return bytes;
  std::string text;
  text.reserve(bytes.size());
  for (size_t i = 0; i < bytes.size(); ++i)
    if (bytes[i] != '\r')
      text += bytes[i];
    else if (i + 1 == bytes.size() || bytes[i + 1] != '\n')
      text += '\n';
  return text;
}

}  // namespace tessera
