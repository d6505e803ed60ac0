// Which files of the folder the view serves, how a path of a request leads to one of them, and
// which part of it a Range header asks for. Source: RFC 9110 §14.
#pragma once
#include <unistd.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace tessera {

/// A file descriptor that is closed with its owner.
class OpenFile {
 public:
  OpenFile() = default;
  /// Takes ownership of `descriptor`; a negative one is no file.
  explicit OpenFile(int descriptor) : descriptor_(descriptor) {}
  OpenFile(OpenFile&& other) noexcept : descriptor_(other.release()) {}
  OpenFile& operator=(OpenFile&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    return *this;
  }
  ~OpenFile() {
    if (is_open()) ::close(descriptor_);
  }

  bool is_open() const { return descriptor_ >= 0; }
  int descriptor() const { return descriptor_; }
  /// Gives the descriptor to the caller, who closes it.
  int release() { return std::exchange(descriptor_, -1); }

 private:
  int descriptor_ = -1;
};

/// The names of folders and file in the path of a request, as it was received: it begins with a
/// slash, and `%XX` is decoded once. An empty last name, of a path that ends with a slash, becomes
/// index.html. Nothing for paths that could mean something else to a browser, a proxy or the file
/// system: empty and hidden names, `.` and `..`, and names with a slash, a backslash, a percent
/// sign or a control character in them, encoded or not.
std::optional<std::vector<std::string>> path_components(std::string_view path);

/// The media type of files that the view serves: pages, images, and what the player plays. Nothing
/// for other files, which are not served. Upper and lower case of the extension are the same.
std::optional<std::string_view> media_type(std::string_view file_name);

struct ServedFile {
  OpenFile file;
  uint64_t size = 0;  // bytes
};

/// Opens a regular file below the open folder `root`, name by name and without following symbolic
/// links, so that no exchange of a folder for a link leads out of it. Nothing where there is none.
std::optional<ServedFile> open_served_file(const OpenFile& root,
                                           const std::vector<std::string>& components);

struct ByteRange {
  uint64_t offset = 0, bytes = 0;
};

/// Whether the header counts in bytes. Other units are ignored, as RFC 9110 requires.
bool is_byte_range(std::string_view header);

/// The part of a file of `size` bytes that `header` names. A last byte behind the end is moved to
/// the end. Nothing, which is answered with 416: several ranges, a reversed range, one behind the
/// end, numbers of more than 18 digits, and all that is no range; RFC 9110 allows to reject these.
std::optional<ByteRange> parse_byte_range(std::string_view header, uint64_t size);

}  // namespace tessera
