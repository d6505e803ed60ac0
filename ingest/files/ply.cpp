// Reads the body of a PLY with one cursor for each encoding and one loop over rows, and writes
// tables.
#include "ingest/files/ply.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>

#include "ingest/files/atomic_file.h"
#include "ingest/files/ply_header.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

static_assert(std::endian::native == std::endian::little, "npy and ply code copies bytes as is");

template <class T>
double load_as(const char* bytes, bool swap) {
  char ordered[sizeof(T)];
  for (size_t i = 0; i < sizeof(T); ++i) ordered[i] = bytes[swap ? sizeof(T) - 1 - i : i];
  T value;
  std::memcpy(&value, ordered, sizeof(T));
  return double(value);
}

double load(PlyType type, const char* bytes, bool swap) {
  switch (type) {
    case PlyType::kInt8:
      return load_as<int8_t>(bytes, swap);
    case PlyType::kUint8:
      return load_as<uint8_t>(bytes, swap);
    case PlyType::kInt16:
      return load_as<int16_t>(bytes, swap);
    case PlyType::kUint16:
      return load_as<uint16_t>(bytes, swap);
    case PlyType::kInt32:
      return load_as<int32_t>(bytes, swap);
    case PlyType::kUint32:
      return load_as<uint32_t>(bytes, swap);
    case PlyType::kFloat32:
      return load_as<float>(bytes, swap);
    case PlyType::kFloat64:
      return load_as<double>(bytes, swap);
  }
  return 0;
}

template <class T>
void store_as(double value, std::string& bytes) {
  T stored;
  if constexpr (std::is_floating_point_v<T>) {
    stored = T(value);
  } else {
    check(value >= double(std::numeric_limits<T>::min()) &&
              value <= double(std::numeric_limits<T>::max()),
          "write_ply: a value outside its integer column type");
    stored = T(std::llround(value));
  }
  char raw[sizeof(T)];
  std::memcpy(raw, &stored, sizeof(T));
  bytes.append(raw, sizeof(T));
}

void store(PlyType type, double value, std::string& bytes) {
  switch (type) {
    case PlyType::kInt8:
      return store_as<int8_t>(value, bytes);
    case PlyType::kUint8:
      return store_as<uint8_t>(value, bytes);
    case PlyType::kInt16:
      return store_as<int16_t>(value, bytes);
    case PlyType::kUint16:
      return store_as<uint16_t>(value, bytes);
    case PlyType::kInt32:
      return store_as<int32_t>(value, bytes);
    case PlyType::kUint32:
      return store_as<uint32_t>(value, bytes);
    case PlyType::kFloat32:
      return store_as<float>(value, bytes);
    case PlyType::kFloat64:
      return store_as<double>(value, bytes);
  }
}

/// Takes one value after the other from the body; false when the file has ended or is malformed.
class Cursor {
 public:
  Cursor(PlyEncoding encoding, std::string_view body) : encoding_(encoding), body_(body) {}

  bool next(PlyType type, double& value) {
    return encoding_ == PlyEncoding::kAscii ? next_word(value) : next_binary(type, value);
  }
  int64_t left() const { return int64_t(body_.size()); }

 private:
  bool next_binary(PlyType type, double& value) {
    const size_t size = ply_type_size(type);
    if (body_.size() < size) return false;
    value = load(type, body_.data(), encoding_ == PlyEncoding::kBigEndian);
    body_.remove_prefix(size);
    return true;
  }

  bool next_word(double& value) {
    const size_t start = body_.find_first_not_of(" \t\r\n");
    if (start == std::string_view::npos) return false;
    body_.remove_prefix(start);
    const size_t length = std::min(body_.find_first_of(" \t\r\n"), body_.size());
    const size_t plus = body_.front() == '+' ? 1 : 0;  // from_chars does not take it
    const char* const end = body_.data() + length;
    const auto parsed = std::from_chars(body_.data() + plus, end, value);
    // Out of range: denormals and overflows keep what from_chars cannot give; 0 is the near value.
    if (parsed.ec == std::errc::result_out_of_range) value = 0;
    if (parsed.ec == std::errc::invalid_argument || parsed.ptr != end) return false;
    body_.remove_prefix(length);
    return true;
  }

  PlyEncoding encoding_;
  std::string_view body_;
};

/// The fewest bytes one row can take: an ASCII value and its separator are two.
int64_t least_row_bytes(const PlyElementLayout& element, PlyEncoding encoding) {
  int64_t bytes = 0;
  for (const PlyPropertyLayout& property : element.properties)
    bytes +=
        encoding == PlyEncoding::kAscii
            ? 2
            : int64_t(ply_type_size(property.list_count ? *property.list_count : property.type));
  return bytes;
}

/// Reads one row; scalars go to `columns` in order (list values are passed over).
bool read_row(Cursor& cursor, const PlyElementLayout& layout, std::vector<PlyColumn>& columns) {
  size_t column = 0;
  double value = 0;
  for (const PlyPropertyLayout& property : layout.properties) {
    if (!property.list_count) {
      if (!cursor.next(property.type, value)) return false;
      columns[column++].values.push_back(value);
      continue;
    }
    double count = 0;
    if (!cursor.next(*property.list_count, count) || count < 0) return false;
    for (double i = 0; i < count; ++i)
      if (!cursor.next(property.type, value)) return false;
  }
  return true;
}

PlyElement read_element(const std::filesystem::path& path, const PlyElementLayout& layout,
                        PlyEncoding encoding, Cursor& cursor) {
  if (layout.properties.empty() && layout.rows > 0)
    throw InputError(
        fmt::format("{}: promises {} rows of '{}', which has no properties; export it again",
                    path.string(), layout.rows, layout.name));
  const int64_t row_bytes = least_row_bytes(layout, encoding);
  // The last ASCII value needs no separator, hence the + 1.
  if (row_bytes > 0 && layout.rows > (cursor.left() + 1) / row_bytes)
    throw InputError(fmt::format(
        "{}: promises {} rows of '{}', has bytes for {} at most (truncated); copy or export it "
        "again",
        path.string(), layout.rows, layout.name, (cursor.left() + 1) / row_bytes));
  PlyElement element{layout.name, layout.rows, {}};
  for (const PlyPropertyLayout& property : layout.properties)
    if (!property.list_count) {
      element.columns.push_back({property.name, property.type, {}});
      element.columns.back().values.reserve(size_t(layout.rows));
    }
  for (int64_t row = 0; row < layout.rows; ++row)
    if (!read_row(cursor, layout, element.columns))
      throw InputError(fmt::format(
          "{}: row {} of the {} rows of '{}' is missing or malformed; copy or export it again",
          path.string(), row, layout.rows, layout.name));
  return element;
}

}  // namespace

const PlyColumn* PlyElement::find(const std::string& column) const {
  for (const PlyColumn& candidate : columns)
    if (candidate.name == column) return &candidate;
  return nullptr;
}

const PlyElement* PlyFile::find(const std::string& element) const {
  for (const PlyElement& candidate : elements)
    if (candidate.name == element) return &candidate;
  return nullptr;
}

std::vector<double> comment_numbers(const std::filesystem::path& path,
                                    const std::vector<std::string>& comments,
                                    const std::string& key, size_t count) {
  for (const std::string& comment : comments) {
    if (comment.rfind(key + " ", 0) != 0) continue;
    std::vector<double> numbers;
    const char* cursor = comment.data() + key.size();
    const char* const end = comment.data() + comment.size();
    while (cursor < end && *cursor == ' ') {
      double value = 0;
      const auto parsed = std::from_chars(cursor + 1, end, value);
      if (parsed.ec != std::errc() || !std::isfinite(value)) break;
      numbers.push_back(value);
      cursor = parsed.ptr;
    }
    if (numbers.size() == count && cursor == end) return numbers;
    throw InputError(
        fmt::format("{}: comment '{}' is malformed, expected {} numbers, finite; export again",
                    path.string(), comment, count));
  }
  return {};
}

PlyFile read_ply(const std::filesystem::path& path) {
  const std::string bytes = read_text_file(path);
  const PlyHeader header = parse_ply_header(path, bytes);
  Cursor cursor(header.encoding, std::string_view(bytes).substr(header.body_offset));
  PlyFile file;
  file.comments = header.comments;
  for (const PlyElementLayout& layout : header.elements)
    file.elements.push_back(read_element(path, layout, header.encoding, cursor));
  return file;
}

void write_ply(const std::filesystem::path& path, const PlyFile& file) {
  constexpr size_t kFlushBytes = 1 << 20;
  AtomicFile output(path);
  std::string bytes = ply_header_text(file);
  for (const PlyElement& element : file.elements) {
    for (const PlyColumn& column : element.columns)
      check(int64_t(column.values.size()) == element.rows, "write_ply: column length");
    for (size_t row = 0; row < size_t(element.rows); ++row) {
      for (const PlyColumn& column : element.columns) store(column.type, column.values[row], bytes);
      if (bytes.size() < kFlushBytes) continue;
      output.write(bytes);
      bytes.clear();
    }
  }
  output.write(bytes);
  output.commit();
}

}  // namespace tessera
