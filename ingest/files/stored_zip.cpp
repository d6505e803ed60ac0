// Writes local headers, contents, the central directory and its end record; reads by the central
// directory, because writers may leave out the sizes in local headers.
#include "ingest/files/stored_zip.h"

#include <fmt/format.h>

#include "ingest/files/bytes.h"
#include "ingest/files/gzip.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

constexpr uint32_t kLocalMark = 0x04034b50, kCentralMark = 0x02014b50, kEndMark = 0x06054b50;
constexpr uint16_t kVersionNeeded = 20, kUtf8Names = 0x800, kEncrypted = 1, kFirstDay = 0x21;
constexpr uint16_t kStored = 0;
constexpr uint64_t kEndBytes = 22, kMostComment = 65535;

/// The fields that local headers and the central directory share.
struct ZipFields {
  uint16_t flags = kUtf8Names, method = kStored;
  uint32_t crc = 0, packed = 0, plain = 0;
  uint16_t name_bytes = 0, extra_bytes = 0;
};

void append_fields(std::string& bytes, const ZipEntry& entry) {
  append(bytes, kVersionNeeded);
  append(bytes, kUtf8Names);
  append(bytes, kStored);
  append(bytes, uint16_t{0});  // time
  append(bytes, kFirstDay);    // 1980-01-01
  append(bytes, crc32_of(entry.bytes));
  append(bytes, uint32_t(entry.bytes.size()));
  append(bytes, uint32_t(entry.bytes.size()));
  append(bytes, uint16_t(entry.name.size()));
  append(bytes, uint16_t{0});  // extra fields
}

ZipFields read_fields(ByteReader& bytes) {
  ZipFields fields;
  bytes.take(2);
  fields.flags = bytes.number<uint16_t>();
  fields.method = bytes.number<uint16_t>();
  bytes.take(4);
  fields.crc = bytes.number<uint32_t>();
  fields.packed = bytes.number<uint32_t>();
  fields.plain = bytes.number<uint32_t>();
  fields.name_bytes = bytes.number<uint16_t>();
  fields.extra_bytes = bytes.number<uint16_t>();
  return fields;
}

InputError damaged(const std::filesystem::path& path, const char* what) {
  return InputError(fmt::format("{}: {}; the zip archive is cut off or damaged, fetch it again",
                                path.string(), what));
}

/// Where the last end record begins: a comment may follow it.
uint64_t end_record(std::string_view archive, const std::filesystem::path& path) {
  const std::string_view mark("PK\5\6", 4);
  if (archive.size() < kEndBytes) throw damaged(path, "it has no end record");
  const size_t start = archive.rfind(mark, archive.size() - kEndBytes);
  if (start == std::string_view::npos || archive.size() - start > kEndBytes + kMostComment)
    throw damaged(path, "it has no end record");
  return start;
}

/// The content of an entry, behind the local header at `offset`.
std::string_view content_at(std::string_view archive, uint64_t offset, const ZipFields& entry,
                            const std::string& name, const std::filesystem::path& path) {
  if (offset > archive.size()) throw damaged(path, "an entry begins behind its end");
  if ((entry.flags & kEncrypted) != 0 || entry.method != kStored || entry.packed != entry.plain)
    throw InputError(
        fmt::format("{}: its entry '{}' is compressed or encrypted; store the entries without "
                    "compression (zip -0)",
                    path.string(), name));
  ByteReader local(archive.substr(offset), path);
  if (local.number<uint32_t>() != kLocalMark) throw damaged(path, "an entry has no header");
  const ZipFields fields = read_fields(local);
  local.take(uint64_t(fields.name_bytes) + fields.extra_bytes);
  const std::string_view content = local.take(entry.plain);
  if (crc32_of(content) != entry.crc) throw damaged(path, "the checksum of an entry differs");
  return content;
}

}  // namespace

bool is_zip(std::string_view head) {
  return head.starts_with("PK\3\4");
}

std::string stored_zip(const std::vector<ZipEntry>& entries) {
  std::string bytes, directory;
  for (const ZipEntry& entry : entries) {
    const uint64_t offset = bytes.size();
    check(offset + entry.bytes.size() < UINT32_MAX && entry.name.size() <= UINT16_MAX,
          "stored_zip: 4 GiB and more need zip64");
    append(bytes, kLocalMark);
    append_fields(bytes, entry);
    bytes += entry.name + entry.bytes;
    append(directory, kCentralMark);
    append(directory, kVersionNeeded);  // of the writer
    append_fields(directory, entry);
    directory.append(10, '\0');  // comment, disk, attributes
    append(directory, uint32_t(offset));
    directory += entry.name;
  }
  const uint64_t start = bytes.size();
  bytes += directory;
  append(bytes, kEndMark);
  append(bytes, uint32_t{0});  // disks
  append(bytes, uint16_t(entries.size()));
  append(bytes, uint16_t(entries.size()));
  append(bytes, uint32_t(directory.size()));
  append(bytes, uint32_t(start));
  append(bytes, uint16_t{0});  // comment
  return bytes;
}

std::map<std::string, std::string_view> zip_contents(std::string_view archive,
                                                     const std::filesystem::path& path) {
  ByteReader end(archive.substr(end_record(archive, path)), path);
  end.take(10);
  const auto count = end.number<uint16_t>();
  const auto directory_bytes = end.number<uint32_t>();
  const auto directory_start = end.number<uint32_t>();
  if (directory_start > archive.size()) throw damaged(path, "its directory begins behind its end");
  ByteReader outer(archive.substr(directory_start), path);
  ByteReader directory(outer.take(directory_bytes), path);
  std::map<std::string, std::string_view> contents;
  for (int i = 0; i < count; ++i) {
    if (directory.number<uint32_t>() != kCentralMark)
      throw damaged(path, "its directory has an entry without a header");
    directory.take(2);
    const ZipFields fields = read_fields(directory);
    const auto comment_bytes = directory.number<uint16_t>();
    directory.take(8);
    const auto offset = directory.number<uint32_t>();
    const std::string name(directory.take(fields.name_bytes));
    directory.take(uint64_t(fields.extra_bytes) + comment_bytes);
    contents[name] = content_at(archive, offset, fields, name, path);
  }
  return contents;
}

}  // namespace tessera
