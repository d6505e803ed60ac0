// Writes and reads zip archives whose entries are stored, that is, not compressed. Names are ASCII
// or UTF-8, and entries have no time, so that equal input gives equal output. Source: APPNOTE.TXT
// of PKWARE, sections 4.3.7, 4.3.12 and 4.3.16.
#pragma once
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace tessera {

struct ZipEntry {
  std::string name, bytes;
};

bool is_zip(std::string_view head);
/// The bytes of an archive of less than 4 GiB.
std::string stored_zip(const std::vector<ZipEntry>& entries);

/// Contents by name, parts of `archive`. Errors: InputError naming `path`: no archive, cut off,
/// damaged, encrypted or compressed entries, zip64.
std::map<std::string, std::string_view> zip_contents(std::string_view archive,
                                                     const std::filesystem::path& path);

}  // namespace tessera
