// Compresses by libdeflate, all at once; zlib decompresses piece by piece, up to a limit.
#include "ingest/files/gzip.h"

#include <fmt/format.h>
#include <libdeflate.h>
#include <zlib.h>

#include <algorithm>
#include <climits>
#include <memory>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

constexpr int kGzipWindow = 15 + 16;  // the largest window, gzip's wrapper
constexpr size_t kStep = size_t{1} << 20;

/// zlib counts in unsigned int: feeds what fits.
void feed(z_stream& stream, std::string_view& bytes) {
  if (stream.avail_in > 0) return;
  const size_t count = std::min<size_t>(bytes.size(), UINT_MAX);
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = uInt(count);
  bytes.remove_prefix(count);
}

/// Room for another step at the end of `out`.
void make_room(z_stream& stream, std::string& out, size_t step) {
  const size_t done = out.size() - stream.avail_out;
  out.resize(done + step);
  stream.next_out = reinterpret_cast<Bytef*>(out.data() + done);
  stream.avail_out = uInt(step);
}

}  // namespace

bool is_gzip(std::string_view bytes) {
  return bytes.starts_with("\x1f\x8b");
}

std::string gzip(std::string_view bytes, int level) {
  const std::unique_ptr<libdeflate_compressor, void (*)(libdeflate_compressor*)> deflater(
      libdeflate_alloc_compressor(level), libdeflate_free_compressor);
  check(deflater != nullptr, "gzip: libdeflate does not start");
  std::string out(libdeflate_gzip_compress_bound(deflater.get(), bytes.size()), '\0');
  out.resize(
      libdeflate_gzip_compress(deflater.get(), bytes.data(), bytes.size(), out.data(), out.size()));
  return out;
}

std::string gunzip(std::string_view bytes, uint64_t limit, const std::filesystem::path& path) {
  z_stream stream{};
  check(inflateInit2(&stream, kGzipWindow) == Z_OK, "gunzip: zlib does not start");
  std::string out;
  int state = Z_OK;
  const char* wrong = nullptr;
  while (state != Z_STREAM_END && wrong == nullptr) {
    feed(stream, bytes);
    if (stream.avail_out == 0) make_room(stream, out, kStep);
    state = inflate(&stream, Z_NO_FLUSH);
    const bool starved = state == Z_BUF_ERROR && stream.avail_in == 0 && bytes.empty();
    if (starved)
      wrong = "is cut off";
    else if (state != Z_OK && state != Z_STREAM_END && state != Z_BUF_ERROR)
      wrong = "is damaged";
    else if (out.size() - stream.avail_out > limit)
      wrong = "holds more than its header says";
  }
  out.resize(out.size() - stream.avail_out);
  inflateEnd(&stream);
  if (wrong != nullptr)
    throw InputError(
        fmt::format("{}: its gzip stream {}; fetch or export it again", path.string(), wrong));
  return out;
}

std::string gunzip_head(std::string_view bytes, uint64_t count, const std::filesystem::path& path) {
  z_stream stream{};
  check(inflateInit2(&stream, kGzipWindow) == Z_OK, "gunzip: zlib does not start");
  std::string out(count, '\0');
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = uInt(count);
  int state = Z_OK;
  while (state == Z_OK && stream.avail_out > 0 && (stream.avail_in > 0 || !bytes.empty())) {
    feed(stream, bytes);
    state = inflate(&stream, Z_NO_FLUSH);
  }
  out.resize(count - stream.avail_out);
  inflateEnd(&stream);
  if (state != Z_OK && state != Z_STREAM_END && state != Z_BUF_ERROR)
    throw InputError(
        fmt::format("{}: its gzip stream is damaged; fetch or export it again", path.string()));
  return out;
}

uint32_t crc32_of(std::string_view bytes) {
  return uint32_t(crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

}  // namespace tessera
