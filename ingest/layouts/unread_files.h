// What lies in a capture and is not read, although its user may think so.
#pragma once
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "ingest/capture/capture.h"

namespace tessera {

/// The files that the frames, clips and calibration of a capture are made of.
std::set<std::filesystem::path> taken_files(const Capture& capture);

struct UnreadFiles {
  std::vector<std::string> warnings, notes;
};

/// A warning for each extension of images and videos that this program does not read, with their
/// number, for videos that are not among `taken`, and, of a capture of clips, for folders that are
/// called like cameras and hold images, none of them taken. Other folders of images, where copies
/// of other sizes and depths lie, are one note. Masks, and the folder `masks` of options, are none.
UnreadFiles unread_files(const std::filesystem::path& capture,
                         const std::set<std::filesystem::path>& taken,
                         const std::filesystem::path& masks, bool of_clips);

/// A line for masks that lie beside the images and are not used; "" where there are none.
std::string unused_masks(const std::filesystem::path& capture);

/// `error` with what is said of images and videos that are not read behind it, in one line: where a
/// capture is refused they may be the reason.
std::string with_unread_files(std::string error, const std::filesystem::path& capture);

}  // namespace tessera
