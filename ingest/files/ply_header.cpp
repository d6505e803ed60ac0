// Parses the lines of a PLY header, and formats the header of a table. Unknown keywords such as
// obj_info are skipped.
#include "ingest/files/ply_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

struct TypeName {
  PlyType type;
  std::string_view name, other_name;
  size_t size;
};

constexpr std::array<TypeName, 8> kTypes{{{PlyType::kInt8, "char", "int8", 1},
                                          {PlyType::kUint8, "uchar", "uint8", 1},
                                          {PlyType::kInt16, "short", "int16", 2},
                                          {PlyType::kUint16, "ushort", "uint16", 2},
                                          {PlyType::kInt32, "int", "int32", 4},
                                          {PlyType::kUint32, "uint", "uint32", 4},
                                          {PlyType::kFloat32, "float", "float32", 4},
                                          {PlyType::kFloat64, "double", "float64", 8}}};

std::optional<PlyType> type_named(std::string_view name) {
  for (const TypeName& entry : kTypes)
    if (name == entry.name || name == entry.other_name) return entry.type;
  return std::nullopt;
}

std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  for (size_t position = 0;
       (position = line.find_first_not_of(" \t", position)) != std::string_view::npos;) {
    const size_t end = std::min(line.find_first_of(" \t", position), line.size());
    words.push_back(line.substr(position, end - position));
    position = end;
  }
  return words;
}

/// Hands out header lines without their line ends ("\n" or "\r\n").
class Lines {
 public:
  explicit Lines(std::string_view bytes) : bytes_(bytes) {}
  bool next(std::string_view& line) {
    const size_t end = bytes_.find('\n', at_);
    if (end == std::string_view::npos) return false;
    line = bytes_.substr(at_, end - at_);
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    at_ = end + 1;
    return true;
  }
  size_t offset() const { return at_; }

 private:
  std::string_view bytes_;
  size_t at_ = 0;
};

bool parse_format(const std::vector<std::string_view>& words, PlyHeader& header) {
  if (words.size() < 2) return false;
  if (words[1] == "ascii")
    header.encoding = PlyEncoding::kAscii;
  else if (words[1] == "binary_little_endian")
    header.encoding = PlyEncoding::kLittleEndian;
  else if (words[1] == "binary_big_endian")
    header.encoding = PlyEncoding::kBigEndian;
  else
    return false;
  return true;
}

bool parse_element(const std::vector<std::string_view>& words, PlyHeader& header) {
  if (words.size() != 3) return false;
  PlyElementLayout element{std::string(words[1]), 0, {}};
  const char* const end = words[2].data() + words[2].size();
  const auto parsed = std::from_chars(words[2].data(), end, element.rows);
  if (parsed.ec != std::errc() || parsed.ptr != end || element.rows < 0) return false;
  header.elements.push_back(std::move(element));
  return true;
}

bool parse_property(const std::vector<std::string_view>& words, PlyHeader& header) {
  if (header.elements.empty() || words.size() < 3) return false;
  const bool is_list = words[1] == "list";
  if (words.size() != (is_list ? 5u : 3u)) return false;
  const auto type = type_named(words[is_list ? 3 : 1]);
  const auto count = is_list ? type_named(words[2]) : std::nullopt;
  if (!type || (is_list && !count)) return false;
  header.elements.back().properties.push_back({std::string(words.back()), *type, count});
  return true;
}

bool parse_line(std::string_view line, PlyHeader& header) {
  const auto words = words_of(line);
  if (words.empty() || words[0] == "obj_info") return true;
  if (words[0] == "format") return parse_format(words, header);
  if (words[0] == "element") return parse_element(words, header);
  if (words[0] == "property") return parse_property(words, header);
  if (words[0] != "comment") return false;
  const size_t text = line.find_first_not_of(" \t", line.find("comment") + 7);
  header.comments.emplace_back(text == std::string_view::npos ? "" : line.substr(text));
  return true;
}

}  // namespace

size_t ply_type_size(PlyType type) {
  return kTypes[size_t(type)].size;
}

PlyHeader parse_ply_header(const std::filesystem::path& path, std::string_view bytes) {
  PlyHeader header;
  Lines lines(bytes);
  std::string_view line;
  if (!lines.next(line) || line != "ply")
    throw InputError(
        fmt::format("{}: does not start with 'ply'; expected a PLY file, check what this file is",
                    path.string()));
  bool has_format = false;
  while (lines.next(line)) {
    if (line == "end_header") {
      header.body_offset = lines.offset();
      if (has_format) return header;
      break;
    }
    if (!parse_line(line, header))
      throw InputError(fmt::format("{}: PLY header line '{}' is not understood; export it again",
                                   path.string(), line.substr(0, 80)));
    has_format = has_format || line.substr(0, 6) == "format";
  }
  throw InputError(fmt::format("{}: PLY header has no '{}' line (truncated?); export it again",
                               path.string(), has_format ? "end_header" : "format"));
}

std::string ply_header_text(const PlyFile& file) {
  std::string text = "ply\nformat binary_little_endian 1.0\n";
  for (const std::string& comment : file.comments) text += fmt::format("comment {}\n", comment);
  for (const PlyElement& element : file.elements) {
    text += fmt::format("element {} {}\n", element.name, element.rows);
    for (const PlyColumn& column : element.columns)
      text += fmt::format("property {} {}\n", kTypes[size_t(column.type)].name, column.name);
  }
  return text + "end_header\n";
}

}  // namespace tessera
