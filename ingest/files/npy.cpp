// Parses the header of a .npy file: a Python dictionary literal with three known keys in any order.
// Format: numpy.lib.format, versions 1.0 and 2.0.
#include "ingest/files/npy.h"

#include <fmt/format.h>

#include <bit>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include "ingest/files/atomic_file.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

static_assert(std::endian::native == std::endian::little, "npy and ply code copies bytes as is");

constexpr std::string_view kMagic = "\x93NUMPY";

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& seen) {
  throw InputError(
      fmt::format("{}: {}; expected a two-dimensional NumPy array of little-endian floats",
                  path.string(), seen));
}

/// What follows `'key':` in the header dictionary, blanks skipped; empty when the key is missing.
std::string_view value_of(std::string_view header, std::string_view key) {
  const size_t position = header.find(fmt::format("'{}'", key));
  if (position == std::string_view::npos) return {};
  const size_t colon = header.find(':', position);
  if (colon == std::string_view::npos) return {};
  const size_t value = header.find_first_not_of(' ', colon + 1);
  return value == std::string_view::npos ? std::string_view{} : header.substr(value);
}

/// The integers of a tuple "(20, 17)" or "(5,)"; nothing when it is malformed or too large.
std::optional<std::vector<int64_t>> parse_tuple(std::string_view text) {
  if (text.empty() || text.front() != '(') return std::nullopt;
  std::vector<int64_t> values;
  bool in_number = false;
  for (const char c : text.substr(1)) {
    if (c == ')') return values;
    if (c >= '0' && c <= '9') {
      if (!in_number) values.push_back(0);
      if (values.back() > std::numeric_limits<int32_t>::max()) return std::nullopt;
      values.back() = values.back() * 10 + (c - '0');
      in_number = true;
    } else if (c == ',' || c == ' ') {
      in_number = false;
    } else {
      return std::nullopt;
    }
  }
  return std::nullopt;
}

struct Layout {
  int64_t rows = 0, columns = 0;
  size_t value_bytes = 0;
  bool fortran_order = false;
};

Layout parse_header(const std::filesystem::path& path, std::string_view header) {
  Layout layout;
  const std::string_view type = value_of(header, "descr").substr(0, 5);
  if (type == "'<f8'")
    layout.value_bytes = 8;
  else if (type == "'<f4'")
    layout.value_bytes = 4;
  else
    fail(path, fmt::format("has values of type {}", type.empty() ? "(none stated)" : type));
  layout.fortran_order = value_of(header, "fortran_order").substr(0, 4) == "True";
  const auto shape = parse_tuple(value_of(header, "shape"));
  if (!shape) fail(path, "has no readable shape");
  if (shape->size() != 2) fail(path, fmt::format("has {} dimensions", shape->size()));
  layout.rows = (*shape)[0];
  layout.columns = (*shape)[1];
  return layout;
}

double value_at(std::string_view data, const Layout& layout, int64_t index) {
  const char* from = data.data() + size_t(index) * layout.value_bytes;
  if (layout.value_bytes == 4) {
    float value;
    std::memcpy(&value, from, 4);
    return double(value);
  }
  double value;
  std::memcpy(&value, from, 8);
  return value;
}

}  // namespace

Matrix read_npy(const std::filesystem::path& path) {
  const std::string bytes = read_text_file(path);
  const std::string_view text = bytes;
  if (text.substr(0, kMagic.size()) != kMagic) fail(path, "is not an .npy file");
  if (text.size() < 12) fail(path, fmt::format("is truncated after {} bytes", text.size()));
  const int version = uint8_t(text[6]);
  if (version != 1 && version != 2) fail(path, fmt::format("has .npy version {}", version));
  const size_t length_bytes = version == 1 ? 2 : 4;
  size_t header_size = 0;
  for (size_t i = 0; i < length_bytes; ++i) header_size |= size_t(uint8_t(text[8 + i])) << (8 * i);
  const size_t start = 8 + length_bytes;
  if (header_size > text.size() - start) fail(path, "is truncated inside its header");
  const Layout layout = parse_header(path, text.substr(start, header_size));
  const std::string_view data = text.substr(start + header_size);
  const auto stored = int64_t(data.size() / layout.value_bytes);
  if (layout.columns > 0 && layout.rows > stored / layout.columns)
    fail(path, fmt::format("promises {} rows of {} values, holds {} values (truncated)",
                           layout.rows, layout.columns, stored));
  Matrix matrix{layout.rows, layout.columns, {}};
  matrix.data.resize(size_t(layout.rows * layout.columns));
  for (int64_t r = 0; r < layout.rows; ++r)
    for (int64_t c = 0; c < layout.columns; ++c)
      matrix(r, c) = value_at(data, layout,
                              layout.fortran_order ? c * layout.rows + r : r * layout.columns + c);
  return matrix;
}

void write_npy(const std::filesystem::path& path, const Matrix& matrix) {
  check(int64_t(matrix.data.size()) == matrix.rows * matrix.columns, "write_npy shape");
  std::string header =
      fmt::format("{{'descr': '<f8', 'fortran_order': False, 'shape': ({}, {}), }}", matrix.rows,
                  matrix.columns);
  const size_t prefix = kMagic.size() + 4;
  header.append(63 - (prefix + header.size()) % 64, ' ');  // data starts at a multiple of 64
  header += '\n';
  AtomicFile file(path);
  file.write(kMagic);
  const char version_and_size[4] = {1, 0, char(header.size() & 0xff), char(header.size() >> 8)};
  file.write(version_and_size, 4);
  file.write(header);
  file.write(matrix.data.data(), matrix.data.size() * sizeof(double));
  file.commit();
}

}  // namespace tessera
