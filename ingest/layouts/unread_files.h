// What lies in a capture and is not read, although its user may think so.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "ingest/video/clip.h"

namespace tessera {

/// A line for each extension of images and videos that this program does not read, with their
/// number, and one for masks that lie beside the images where `has_masks` is false. Looks at the
/// capture and two levels below; hidden files and folders do not count, and folders that cannot be
/// listed are passed over.
std::vector<std::string> unread_files(const std::filesystem::path& capture, bool has_masks);

/// A line for videos below a capture of videos, and one for folders that are called like cameras
/// and hold images, which are none of `clips`. Looks two levels and one level below.
std::vector<std::string> unread_clips(const std::filesystem::path& capture,
                                      const std::vector<RigClip>& clips);

/// `error` with what unread_files() says of images and videos behind it, in one line: where a
/// capture is refused they may be the reason.
std::string with_unread_files(std::string error, const std::filesystem::path& capture);

}  // namespace tessera
