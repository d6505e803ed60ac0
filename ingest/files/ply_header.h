// The header of a PLY: elements and their properties in the order of the file, including lists.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ingest/files/ply.h"

namespace tessera {

enum class PlyEncoding { kAscii, kLittleEndian, kBigEndian };

struct PlyPropertyLayout {
  std::string name;
  PlyType type = PlyType::kFloat32;   // of the value, or of each list value
  std::optional<PlyType> list_count;  // set for lists: the type of the length
};

struct PlyElementLayout {
  std::string name;
  int64_t rows = 0;
  std::vector<PlyPropertyLayout> properties;
};

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::kAscii;
  std::vector<std::string> comments;
  std::vector<PlyElementLayout> elements;
  size_t body_offset = 0;  // bytes from the start of the file
};

size_t ply_type_size(PlyType type);

/// Errors: InputError naming `path` and the line that is wrong.
PlyHeader parse_ply_header(const std::filesystem::path& path, std::string_view bytes);
/// The header of a binary little-endian file with the columns of `file`.
std::string ply_header_text(const PlyFile& file);

}  // namespace tessera
