// Compresses and decompresses gzip data in memory. The header has no file name or time, so that
// equal input gives equal output.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace tessera {

bool is_gzip(std::string_view bytes);
/// `level`: 1 to 12.
std::string gzip(std::string_view bytes, int level = 12);
/// At most `limit` bytes. Errors: InputError naming `path`: damaged, cut off, or more than `limit`.
std::string gunzip(std::string_view bytes, uint64_t limit, const std::filesystem::path& path);

/// The first `count` bytes of what is packed, fewer where there are not more. Errors: as above.
std::string gunzip_head(std::string_view bytes, uint64_t count, const std::filesystem::path& path);

/// The checksum that gzip uses.
uint32_t crc32_of(std::string_view bytes);

}  // namespace tessera
