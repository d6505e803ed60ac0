// Decodes paths, lists the media types, and opens files component by component.
#include "tools/view/served_file.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <charconv>

#include "kernels/base/lower_case.h"
#include "tools/view/view_request.h"

namespace tessera {
namespace {

constexpr size_t kMostPathBytes = 2048;
constexpr const char* kIndexFile = "index.html";

struct MediaType {
  std::string_view extension, type;
};
constexpr MediaType kMediaTypes[] = {
    {".html", "text/html; charset=utf-8"},
    {".css", "text/css; charset=utf-8"},
    {".js", "text/javascript; charset=utf-8"},
    {".json", "application/json"},
    {".csv", "text/csv; charset=utf-8"},
    {".svg", "image/svg+xml"},
    {".png", "image/png"},
    {".jpg", "image/jpeg"},
    {".jpeg", "image/jpeg"},
    {".webp", "image/webp"},
    {".gif", "image/gif"},
    {".mp4", "video/mp4"},
    {".mp3", "audio/mpeg"},
    {".m4a", "audio/mp4"},
    {".ogg", "audio/ogg"},
    {".opus", "audio/ogg"},
    {".wav", "audio/wav"},
    {".bin", "application/octet-stream"},
    {".t4d", "application/octet-stream"},
    {".ply", "application/octet-stream"},
    {".spz", "application/octet-stream"},
    {".sog", "application/octet-stream"},
    {".splat", "application/octet-stream"},
};

int hexadecimal(char digit) {
  if (digit >= '0' && digit <= '9') return digit - '0';
  if (digit >= 'a' && digit <= 'f') return digit - 'a' + 10;
  if (digit >= 'A' && digit <= 'F') return digit - 'A' + 10;
  return -1;
}

std::optional<std::string> decoded(std::string_view text) {
  std::string result;
  for (size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      result += text[i];
      continue;
    }
    if (text.size() - i < 3) return {};
    const int high = hexadecimal(text[i + 1]), low = hexadecimal(text[i + 2]);
    if (high < 0 || low < 0) return {};
    result += static_cast<char>(high * 16 + low);
    i += 2;
  }
  return result;
}

/// `.` and `..` are hidden names as well.
bool is_served_name(std::string_view name) {
  return !name.empty() && name[0] != '.' && std::none_of(name.begin(), name.end(), [](char c) {
    return c == '/' || c == '\\' || c == '%' || static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
  });
}

constexpr std::string_view kUnit = "bytes=";
constexpr size_t kMostDigits = 18;  // so that sums stay within 64 bits

bool is_number(std::string_view text) {
  return !text.empty() && text.size() <= kMostDigits &&
         std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

uint64_t number(std::string_view digits) {
  uint64_t value = 0;
  std::from_chars(digits.data(), digits.data() + digits.size(), value);
  return value;
}

}  // namespace

std::optional<std::vector<std::string>> path_components(std::string_view path) {
  if (path.size() > kMostPathBytes || !path.starts_with('/')) return {};
  std::vector<std::string> components;
  while (!path.empty()) {
    path.remove_prefix(1);  // the slash
    const std::string_view raw = path.substr(0, path.find('/'));
    path.remove_prefix(raw.size());
    std::optional<std::string> name = decoded(raw);
    if (name && name->empty() && path.empty()) name = kIndexFile;
    if (!name || !is_served_name(*name)) return {};
    components.push_back(*std::move(name));
  }
  return components;
}

std::optional<std::string_view> media_type(std::string_view file_name) {
  const std::string extension =
      lower_case(file_name.substr(std::min(file_name.rfind('.'), file_name.size())));
  for (const MediaType& row : kMediaTypes)
    if (row.extension == extension) return row.type;
  return {};
}

std::optional<ServedFile> open_served_file(const OpenFile& root,
                                           const std::vector<std::string>& components) {
  if (components.empty()) return {};
  OpenFile folder;
  int parent = root.descriptor();
  for (size_t i = 0; i + 1 < components.size(); ++i) {
    folder = OpenFile(
        ::openat(parent, components[i].c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
    if (!folder.is_open()) return {};
    parent = folder.descriptor();
  }
  // O_NONBLOCK: opening a pipe without a writer must not wait
  ServedFile served{OpenFile(
      ::openat(parent, components.back().c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC))};
  struct stat status {};
  if (!served.file.is_open() || ::fstat(served.file.descriptor(), &status) != 0 ||
      !S_ISREG(status.st_mode))
    return {};
  served.size = static_cast<uint64_t>(status.st_size);
  return served;
}

bool is_byte_range(std::string_view header) {
  return header.starts_with(kUnit);
}

std::optional<ByteRange> parse_byte_range(std::string_view header, uint64_t size) {
  if (!is_byte_range(header) || size == 0) return {};
  const std::string_view range = header.substr(kUnit.size());
  const size_t dash = range.find('-');
  if (dash == std::string_view::npos) return {};
  const std::string_view first = range.substr(0, dash), last = range.substr(dash + 1);
  if (first.empty()) {
    if (!is_number(last) || number(last) == 0) return {};
    const uint64_t bytes = std::min(number(last), size);
    return ByteRange{size - bytes, bytes};
  }
  if (!is_number(first) || number(first) >= size) return {};
  if (last.empty()) return ByteRange{number(first), size - number(first)};
  if (!is_number(last) || number(last) < number(first)) return {};
  return ByteRange{number(first), std::min(number(last), size - 1) - number(first) + 1};
}

}  // namespace tessera
