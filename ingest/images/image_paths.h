// Finds image files: the file that a stated file_path names, the name of its frame, and the images
// in a folder.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace tessera {

struct NumberedImage {
  int64_t number = 0;  // of the frame
  std::filesystem::path file;
};

/// True for the extensions of images, in either case.
bool is_image_name(const std::filesystem::path& path);

/// True for a file, links followed; false, without an error, for a loop of links.
bool is_file(const std::filesystem::path& path);

/// The images directly in `folder` by their extensions, sorted by name; hidden ones left out.
std::vector<std::filesystem::path> images_in(const std::filesystem::path& folder);

/// The existing file of this path with the extension of an image behind it, ".png" first; an empty
/// path where there is none.
std::filesystem::path with_image_extension(const std::filesystem::path& path);

/// The existing image that `file_path` (relative to `folder`, with or without extension) means.
/// Errors: InputError that starts with `where` where there is none.
std::filesystem::path require_image(const std::filesystem::path& folder,
                                    const std::string& file_path, const std::string& where);

/// "./train/r_003.png" → "train/r_003"; root, "." and ".." are dropped, so it is safe below a
/// folder, and it is a plain_name().
std::string name_of_image(const std::string& file_path);

}  // namespace tessera
