// Extensions that say nothing are no reason to lose a file: its first bytes are looked at then.
#include "ingest/images/listing.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <set>
#include <string_view>

#include "ingest/images/image_paths.h"
#include "kernels/base/lower_case.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using std::string_view;

constexpr int kLevels = 4;
constexpr std::array<string_view, 5> kVideos{".mp4", ".mkv", ".mov", ".avi", ".webm"};
/// Each holds more than one lens, or what no decoder here shows as its camera did.
constexpr std::array<string_view, 3> kOtherMedia{".insv", ".360", ".gif"};
constexpr std::array<string_view, 9> kTables{".json", ".yml", ".yaml", ".xml", ".csv",
                                             ".toml", ".txt", ".nvm",  ".out"};
constexpr std::array<string_view, 12> kNoMedia{".npy", ".npz", ".bin", ".ply", ".db",   ".py",
                                               ".md",  ".pth", ".pt",  ".zip", ".ckpt", ".html"};

template <class List>
bool is_one_of(const std::string& extension, const List& extensions) {
  return std::find(extensions.begin(), extensions.end(), extension) != extensions.end();
}

std::string first_bytes(const fs::path& file) {
  std::array<char, 2048> bytes{};
  std::ifstream stream(file, std::ios::binary);
  stream.read(bytes.data(), std::streamsize(bytes.size()));
  return {bytes.data(), size_t(stream.gcount())};
}

/// By the signatures of containers; ISO/IEC 13818-1 (transport streams), 14496-12 (boxes of MP4),
/// RFC 8794 (Matroska), RIFF, ASF, MXF (SMPTE 377).
FileKind kind_of_bytes(const std::string& bytes) {
  const auto has = [&](size_t offset, string_view text) {
    return bytes.size() >= offset + text.size() &&
           string_view(bytes).substr(offset, text.size()) == text;
  };
  using namespace std::string_view_literals;
  const bool is_riff = has(0, "RIFF");
  if (has(4, "ftyp"))
    return has(8, "heic") || has(8, "heix") || has(8, "mif1") || has(8, "avif") || has(8, "crx ")
               ? FileKind::kOtherMedia
               : FileKind::kVideo;
  for (const size_t packet : {size_t(188), size_t(192)})  // 192: with the times of a camcorder
    if (const size_t first = packet - 188; has(first, "G") && has(first + packet, "G"))
      return FileKind::kVideo;
  for (const string_view head :
       {"\x1a\x45\xdf\xa3"sv, "\x30\x26\xb2\x75\x8e\x66\xcf\x11"sv, "FLV"sv, "OggS"sv,
        "\x06\x0e\x2b\x34"sv, "\0\0\x01\xba"sv, "YUV4MPEG2"sv, "DKIF"sv})
    if (has(0, head)) return FileKind::kVideo;
  if (is_riff && has(8, "AVI ")) return FileKind::kVideo;
  for (const string_view head : {"\xff\xd8\xff"sv, "\x89PNG"sv, "II*\0"sv, "MM\0*"sv, "GIF8"sv,
                                 "\0\0\0\x0cjP  "sv, "BM"sv, "v/1\x01"sv, "FUJIFILM"sv})
    if (has(0, head)) return FileKind::kOtherMedia;
  return is_riff && has(8, "WEBP") ? FileKind::kOtherMedia : FileKind::kOther;
}

bool is_left_by_a_system(const std::string& name) {
  return name.starts_with('.') || name == "@eaDir" || name == "Thumbs.db" || name == "__MACOSX";
}

void list_into(const fs::path& folder, int levels, std::set<fs::path>& entered,
               std::vector<ListedFile>& files) {
  std::error_code unreachable;
  if (!entered.insert(fs::weakly_canonical(folder, unreachable)).second) return;
  for (const auto& entry : fs::directory_iterator(folder, unreachable)) {
    std::error_code unresolved;
    if (is_left_by_a_system(entry.path().filename().string())) continue;
    if (!entry.is_directory(unresolved))
      files.push_back({entry.path(), kind_of_file(entry.path())});
    else if (levels > 1)
      list_into(entry.path(), levels - 1, entered, files);
  }
}

}  // namespace

FileKind kind_of_file(const fs::path& file) {
  const std::string extension = lower_case(file.extension().string());
  if (is_image_name(file)) return FileKind::kImage;
  if (is_one_of(extension, kVideos)) return FileKind::kVideo;
  if (is_one_of(extension, kOtherMedia)) return FileKind::kOtherMedia;
  if (is_one_of(extension, kTables)) return FileKind::kTable;
  return is_one_of(extension, kNoMedia) ? FileKind::kOther : kind_of_bytes(first_bytes(file));
}

bool speaks_of_cameras(const fs::path& table) {
  constexpr std::array<string_view, 18> kWords{
      "fx",       "fl_x",   "focal",     "intrinsic",  "extrinsic", "camera",          "rotation",
      "translat", "matrix", "distort",   "quaternion", "pose",      "<opencv_storage", "t_00",
      "pitch",    "roll",   "<document", "<chunk"};
  if (kind_of_file(table) != FileKind::kTable) return false;
  const std::string text = lower_case(first_bytes(table));
  return std::count_if(kWords.begin(), kWords.end(),
                       [&](string_view word) { return text.find(word) != std::string::npos; }) >= 2;
}

std::vector<ListedFile> list_files(const fs::path& folder) {
  std::vector<ListedFile> files;
  std::set<fs::path> entered;
  list_into(folder, kLevels, entered, files);
  std::sort(files.begin(), files.end(),
            [](const ListedFile& a, const ListedFile& b) { return a.path < b.path; });
  return files;
}

}  // namespace tessera
