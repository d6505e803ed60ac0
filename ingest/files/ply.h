// Reads and writes PLY files as tables: elements of named scalar properties. All three encodings
// are read, and binary little-endian is written. Lists are skipped, such as faces after the
// elements that are read.
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

enum class PlyType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

struct PlyColumn {
  std::string name;
  PlyType type = PlyType::kFloat32;
  std::vector<double> values;  // one per row; every PLY type fits a double exactly
};

struct PlyElement {
  std::string name;
  int64_t rows = 0;
  std::vector<PlyColumn> columns;
  /// The column of that name, or null.
  const PlyColumn* find(const std::string& column) const;
};

struct PlyFile {
  std::vector<std::string> comments;
  std::vector<PlyElement> elements;
  const PlyElement* find(const std::string& element) const;
};

/// Numbers behind `key` in the comments, finite; none where it is not there. fmt writes the
/// shortest text that reads back bit-equal. Errors: InputError: other than `count` numbers.
std::vector<double> comment_numbers(const std::filesystem::path& path,
                                    const std::vector<std::string>& comments,
                                    const std::string& key, size_t count);

/// Errors: InputError naming the file: not a PLY, bad header, truncated (rows promised and found).
/// Counts are checked against the file's size before memory is taken.
PlyFile read_ply(const std::filesystem::path& path);
/// Binary little-endian, atomically; columns in order, rows interleaved.
void write_ply(const std::filesystem::path& path, const PlyFile& file);

}  // namespace tessera
