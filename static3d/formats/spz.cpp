// The .spz format of Niantic: quantised columns in one gzip stream (versions 2 and 3) or in one
// zstd stream each (version 4), in a right-up-back world. Version 1, whose positions are half
// floats, is not read, and extensions are skipped. Source: formats 1.5 (nianticlabs/spz, MIT),
// written from its layout.
#include "static3d/formats/splat_formats.h"

#include <fmt/format.h>
#ifdef TESSERA_HAS_ZSTD
#include <zstd.h>
#endif

#include <algorithm>
#include <cmath>

#include "ingest/files/atomic_file.h"
#include "ingest/files/bytes.h"
#include "ingest/files/gzip.h"
#include "recon4d/model/element_edits.h"
#include "recon4d/model/splat_columns.h"
#include "static3d/transform/far_gaussians.h"
#include "static3d/transform/splat_quanta.h"
#include "static3d/transform/world_change.h"

namespace tessera {
namespace {

constexpr uint32_t kSpzMagic = 0x5053474e;  // "NGSP"
constexpr uint32_t kVersion4Header = 32;    // bytes
constexpr int kFractionBits = 12;
constexpr int kGzipLevel = 6;  // 9 takes four times as long for a hundredth of the bytes
constexpr double kColourScale = 0.15;
constexpr uint64_t kMostSplats = uint64_t{1} << 28;
constexpr uint64_t kHeaderBytes = 16;
constexpr uint64_t kMostExtra = 1 << 20;  // behind the columns: extensions
constexpr uint64_t kMostPacked = 2000;    // bytes that one of zstd may promise; gzip ends at 1032
constexpr uint64_t kMostUnasked = 64 << 20;  // bytes that may be promised by as few as there are

constexpr uint8_t kAntialiased = 1;  // of the flags

struct SpzHeader {
  uint32_t magic = kSpzMagic, version = 3, count = 0;
  uint8_t sh_degree = 0, fraction_bits = kFractionBits, flags = 0, streams = 0;
};

/// Columns in their order, bytes each of a splat.
struct SpzColumns {
  std::string_view position, alpha, colour, scale, rotation, sh;
};

SpzHeader read_header(ByteReader& bytes, const std::filesystem::path& path) {
  SpzHeader header;
  header.magic = bytes.number<uint32_t>();
  header.version = bytes.number<uint32_t>();
  header.count = bytes.number<uint32_t>();
  header.sh_degree = bytes.number<uint8_t>();
  header.fraction_bits = bytes.number<uint8_t>();
  header.flags = bytes.number<uint8_t>();
  header.streams = bytes.number<uint8_t>();
  if (header.magic != kSpzMagic)
    throw InputError(fmt::format("{}: no .spz inside; export it again", path.string()));
  if (header.version < 2 || header.version > 4)
    throw InputError(fmt::format("{}: .spz of version {}, read are 2, 3 and 4; convert it",
                                 path.string(), header.version));
  if (header.count > kMostSplats || header.sh_degree > kMaxShDegree || header.fraction_bits > 23)
    throw InputError(
        fmt::format("{}: {} splats of SH degree {} with {} fractional bits is no .spz; fetch it "
                    "again",
                    path.string(), header.count, header.sh_degree, header.fraction_bits));
  return header;
}

uint64_t rotation_bytes(const SpzHeader& header) {
  return header.version == 2 ? 3 : 4;
}
uint64_t sh_bytes(const SpzHeader& header) {
  return uint64_t(3 * (sh_coefficients(header.sh_degree) - 1));
}

/// Bytes of a splat in all columns.
uint64_t splat_bytes(const SpzHeader& header) {
  return 9 + 1 + 3 + 3 + rotation_bytes(header) + sh_bytes(header);
}

/// What gzip holds: the header first, then as much as that says.
std::string unpacked(std::string_view file, const std::filesystem::path& path) {
  const std::string head = gunzip_head(file, kHeaderBytes, path);
  ByteReader bytes(head, path);
  const SpzHeader header = read_header(bytes, path);
  return gunzip(file, kHeaderBytes + header.count * splat_bytes(header) + kMostExtra, path);
}

SpzColumns columns_of(ByteReader& bytes, const SpzHeader& header) {
  SpzColumns columns;
  columns.position = bytes.take_elements(header.count, 9);
  columns.alpha = bytes.take_elements(header.count, 1);
  columns.colour = bytes.take_elements(header.count, 3);
  columns.scale = bytes.take_elements(header.count, 3);
  columns.rotation = bytes.take_elements(header.count, rotation_bytes(header));
  columns.sh = bytes.take_elements(header.count, sh_bytes(header));
  return columns;
}

#ifdef TESSERA_HAS_ZSTD
/// The streams of version 4 one after the other, as versions 2 and 3 hold them.
std::string joined_streams(ByteReader& bytes, const SpzHeader& header,
                           const std::filesystem::path& path) {
  const uint64_t width = splat_bytes(header);
  const uint32_t toc = bytes.number<uint32_t>();
  bytes.take(12);
  if (toc < kVersion4Header)
    throw InputError(
        fmt::format("{}: its table of streams is at {}, inside the header; fetch it "
                    "again",
                    path.string(), toc));
  bytes.take(toc - kVersion4Header);  // extensions
  std::vector<std::pair<uint64_t, uint64_t>> sizes;
  uint64_t total = 0;
  for (int i = 0; i < header.streams; ++i) {
    const uint64_t packed = bytes.number<uint64_t>();
    sizes.emplace_back(packed, bytes.number<uint64_t>());
    if (sizes.back().second > width * header.count - total)
      throw InputError(fmt::format("{}: its streams hold more than {} splats; fetch it again",
                                   path.string(), header.count));
    total += sizes.back().second;
  }
  if (total > kMostPacked * bytes.left() + kMostUnasked)
    throw InputError(fmt::format("{}: its {} bytes promise {}; it is damaged, fetch it again",
                                 path.string(), bytes.left(), total));
  std::string joined;
  joined.resize(total);
  uint64_t position = 0;
  for (const auto& [packed, plain] : sizes) {
    const std::string_view stream = bytes.take(packed);
    const size_t got =
        ZSTD_decompress(joined.data() + position, plain, stream.data(), stream.size());
    if (ZSTD_isError(got) != 0 || got != plain)
      throw InputError(
          fmt::format("{}: a zstd stream of it is damaged; fetch it again", path.string()));
    position += plain;
  }
  return joined;
}
#else
std::string joined_streams(ByteReader&, const SpzHeader&, const std::filesystem::path& path) {
  throw InputError(fmt::format(
      "{}: .spz of version 4, and this build has no zstd; install libzstd-dev and build again, or "
      "convert the file to version 3",
      path.string()));
}
#endif

double byte_at(std::string_view column, uint64_t i) {
  return double(uint8_t(column[i]));
}

float fixed_point(std::string_view column, uint64_t i, int fraction_bits) {
  const uint32_t low = uint32_t(uint8_t(column[3 * i])) |
                       uint32_t(uint8_t(column[3 * i + 1])) << 8 |
                       uint32_t(uint8_t(column[3 * i + 2])) << 16;
  const int32_t value = int32_t(low << 8) >> 8;  // the sign of 24 bits
  return float(std::ldexp(double(value), -fraction_bits));
}

/// Version 2: x, y, z of a quaternion whose w is not negative.
std::array<double, 4> rotation_of_bytes(std::string_view column, uint64_t n) {
  std::array<double, 4> xyzw{};
  for (uint64_t k = 0; k < 3; ++k) xyzw[k] = byte_at(column, 3 * n + k) / 127.5 - 1;
  xyzw[3] = left_out(xyzw, 3);
  return xyzw;
}

constexpr double kSmallest = 511 * 1.4142135623730951;  // 9 bits of magnitude up to √½

/// Smallest three of x, y, z, w: a sign and 9 bits each, the index of the largest on top.
std::array<double, 4> rotation_of_word(uint32_t word) {
  std::array<double, 4> xyzw{};
  const int largest = int(word >> 30);
  for (int k = 3; k >= 0; --k) {
    if (k == largest) continue;
    const double magnitude = double(word & 511) / kSmallest;
    xyzw[size_t(k)] = (word >> 9 & 1) != 0 ? -magnitude : magnitude;
    word >>= 10;
  }
  xyzw[size_t(largest)] = left_out(xyzw, largest);
  return xyzw;
}

uint32_t word_of_rotation(const std::array<double, 4>& xyzw) {
  const int largest = largest_of(xyzw);
  const bool turn = xyzw[size_t(largest)] < 0;
  auto word = uint32_t(largest);
  for (int k = 0; k < 4; ++k) {
    if (k == largest) continue;
    const double value = xyzw[size_t(k)];
    const uint32_t negative = (value < 0) != turn ? 1 : 0;
    word = word << 10 | negative << 9 |
           std::min(511u, uint32_t(std::floor(kSmallest * std::abs(value) + 0.5)));
  }
  return word;
}

void decode(const SpzHeader& header, const SpzColumns& columns, GaussianSet& set) {
  const GaussianSpans<float> to = set.values();
  const uint64_t rest = sh_bytes(header);
  for (uint64_t n = 0; n < header.count; ++n) {
    const auto i = int64_t(n);
    for (uint64_t k = 0; k < 3; ++k) {
      to.at(kMean, i)[k] = fixed_point(columns.position, 3 * n + k, header.fraction_bits);
      to.at(kLogScale, i)[k] = float(byte_at(columns.scale, 3 * n + k) / 16 - 10);
      to.at(kSh, i)[k] = float((byte_at(columns.colour, 3 * n + k) - 127.5) / (255 * kColourScale));
    }
    *to.at(kOpacityLogit, i) = logit_of_byte(byte_at(columns.alpha, n));
    uint32_t word = 0;
    if (header.version != 2) std::memcpy(&word, columns.rotation.data() + 4 * n, 4);
    const std::array<double, 4> q =
        header.version == 2 ? rotation_of_bytes(columns.rotation, n) : rotation_of_word(word);
    for (size_t k = 0; k < 4; ++k) to.at(kRotation, i)[k] = float(q[(k + 3) % 4]);
    for (uint64_t k = 0; k < rest; ++k)
      to.at(kSh, i)[3 + k] = float((byte_at(columns.sh, rest * n + k) - 128) / 128);
  }
}

void append_position(std::string& bytes, const float* mean, int fraction_bits) {
  for (int k = 0; k < 3; ++k) {
    const auto value = int32_t(std::lround(std::ldexp(double(mean[k]), fraction_bits)));
    for (int shift : {0, 8, 16}) append(bytes, uint8_t(uint32_t(value) >> shift & 255));
  }
}

/// Centres of 2^bits equal parts: few different bytes pack well.
uint8_t sh_byte(float value, int bits) {
  const int part = 1 << (8 - bits);
  const int q = int(std::floor(128 * double(std::clamp(value, -4.0f, 4.0f)) + 0.5)) + 128;
  return uint8_t(std::clamp((q + part / 2) / part * part, 0, 255));
}

void append_sh(std::string& bytes, const float* sh, int sh_degree) {
  constexpr int kFirstBits = 5, kRestBits = 4;
  for (int i = 1; i < sh_coefficients(sh_degree); ++i)
    for (int c = 0; c < 3; ++c)
      append(bytes, sh_byte(sh[3 * i + c], i < 4 ? kFirstBits : kRestBits));
}

/// World units: 24 bits with a sign.
double most_at(int fraction_bits) {
  return std::ldexp(1, 23 - fraction_bits) - 1;
}

struct SpzMeans {
  int fraction_bits = kFractionBits;
  HeldRows held;
};

/// Fewer fractional bits where the core, or more than one in a hundred, is out of range.
SpzMeans means_in_range(const std::filesystem::path& path, const GaussianSpans<const float>& set) {
  constexpr double kShare = 1.0 / 128;  // of the half extent: the largest step
  constexpr int64_t kOneIn = 100;
  const FarShells shells(set);
  SpzMeans means;
  for (;; --means.fraction_bits) {
    const double most = most_at(means.fraction_bits);
    const auto holds = [most](const float* mean) {
      return std::abs(mean[0]) <= most && std::abs(mean[1]) <= most && std::abs(mean[2]) <= most;
    };
    means.held = rows_within(set, shells, holds);
    const std::vector<int64_t>& rows = means.held.rows;
    const bool has_core =
        std::all_of(rows.begin(), rows.end(), [&](int64_t n) { return holds(set.at(kMean, n)); });
    if (has_core && kOneIn * int64_t(means.held.beyond.size()) <= set.count) return means;
    const double step = std::ldexp(1, 1 - means.fraction_bits);  // of the next round
    const bool fine = step <= kShare * double(shells.box().half_extent);
    if (!fine && has_core) return means;
    if (!fine)
      throw InputError(fmt::format(
          "{}: .spz holds means within ±{} units in steps of 1/{}, the scene is at ({}, {}, {}); "
          "export as ply",
          path.string(), most, 1 << means.fraction_bits, shells.box().centre[0],
          shells.box().centre[1], shells.box().centre[2]));
  }
}

/// The columns in their order; none that are empty.
std::vector<std::string> streams_of(const GaussianSpans<const float>& from,
                                    const SpzHeader& header) {
  enum { kPositions, kAlphas, kColours, kScales, kRotations, kHarmonics, kStreams };
  std::vector<std::string> streams(kStreams);
  for (int64_t n = 0; n < from.count; ++n) {
    append_position(streams[kPositions], from.at(kMean, n), header.fraction_bits);
    append(streams[kAlphas], opacity_byte(*from.at(kOpacityLogit, n)));
    for (int k = 0; k < 3; ++k) {
      append(streams[kColours], byte_of(255 * kColourScale * from.at(kSh, n)[k] + 127.5));
      append(streams[kScales], byte_of(16 * (double(from.at(kLogScale, n)[k]) + 10)));
    }
    const float* const q = from.at(kRotation, n);
    append(streams[kRotations], word_of_rotation({q[1], q[2], q[3], q[0]}));
    append_sh(streams[kHarmonics], from.at(kSh, n), header.sh_degree);
  }
  std::erase_if(streams, [](const std::string& stream) { return stream.empty(); });
  return streams;
}

void append_header(std::string& bytes, const SpzHeader& header) {
  append(bytes, header.magic);
  append(bytes, header.version);
  append(bytes, header.count);
  append(bytes, header.sh_degree);
  append(bytes, header.fraction_bits);
  append(bytes, header.flags);
  append(bytes, header.streams);
}

#ifdef TESSERA_HAS_ZSTD
/// A file of version 4: header, table of the streams' bytes (packed, plain), streams.
std::string packed_apart(SpzHeader header, const std::vector<std::string>& streams,
                         const std::filesystem::path&) {
  constexpr int kLevel = 12;  // of zstd, as the format's own writer
  header.streams = uint8_t(streams.size());
  std::string bytes, packed;
  append_header(bytes, header);
  append(bytes, kVersion4Header);
  bytes.append(12, '\0');  // the table follows at once
  for (const std::string& stream : streams) {
    std::string part(ZSTD_compressBound(stream.size()), '\0');
    const size_t size =
        ZSTD_compress(part.data(), part.size(), stream.data(), stream.size(), kLevel);
    check(ZSTD_isError(size) == 0, "save_spz: zstd");
    append(bytes, uint64_t(size));
    append(bytes, uint64_t(stream.size()));
    packed.append(part, 0, size);
  }
  return bytes + packed;
}
#else
std::string packed_apart(const SpzHeader&, const std::vector<std::string>&,
                         const std::filesystem::path& path) {
  throw InputError(fmt::format(
      "{}: .spz of version 4, and this build has no zstd; install libzstd-dev and build again, or "
      "export version 3",
      path.string()));
}
#endif

}  // namespace

bool is_spz(std::string_view head) {
  return is_gzip(head) || head.substr(0, 4) == "NGSP";
}

SplatFile load_spz(const std::filesystem::path& path) {
  std::string file = read_text_file(path);
  if (is_gzip(file)) file = unpacked(file, path);
  ByteReader bytes(file, path);
  const SpzHeader header = read_header(bytes, path);
  const std::string streams =
      header.version == 4 ? joined_streams(bytes, header, path) : std::string();
  ByteReader joined(streams, path);
  const SpzColumns columns = columns_of(header.version == 4 ? joined : bytes, header);
  SplatFile result;
  result.set = GaussianSet(SetForm::kStatic, sh_coefficients(header.sh_degree));
  result.set.resize(int64_t(header.count));
  decode(header, columns, result.set);
  flip_axes(result.set, kRightUpBack);
  result.drawing.antialiased = (header.flags & kAntialiased) != 0;
  return result;
}

int64_t save_spz(const std::filesystem::path& path, const GaussianSet& set,
                 const SplatDrawing& drawing, int version) {
  const SpzMeans means = means_in_range(path, set.values());
  GaussianSet flipped = select_elements(set, means.held.rows);
  flip_axes(flipped, kRightUpBack);
  SpzHeader header;
  header.version = uint32_t(version);
  header.count = uint32_t(flipped.count());
  header.sh_degree = uint8_t(drawing.sh_degree);
  header.fraction_bits = uint8_t(means.fraction_bits);
  if (drawing.antialiased) header.flags = kAntialiased;
  const auto left_out = int64_t(means.held.beyond.size());
  const std::vector<std::string> streams = streams_of(std::as_const(flipped).values(), header);
  if (version == 4) {
    write_text_file(path, packed_apart(header, streams, path));
    return left_out;
  }
  std::string bytes;
  append_header(bytes, header);
  for (const std::string& stream : streams) bytes += stream;
  write_text_file(path, gzip(bytes, kGzipLevel));
  return left_out;
}

}  // namespace tessera
