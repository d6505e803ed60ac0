// What names of image files and folders say: a camera, the number of a frame.
#pragma once
#include <cstdint>
#include <optional>
#include <string>

namespace tessera {

struct NumberedName {
  std::string camera;  // may be empty
  int64_t number = 0;
};

/// Whether folders or names of cameras are called so: "cam00", "Camera_B1", "3", "00_12".
bool is_camera_name(const std::string& name);

/// The last number of a file's name without extension, and what stands
/// before it without separators and the word "frame" or the like: "cam00_frame_012" is 12 of cam00.
/// Also with the camera last: "0012_cam00". Nothing where the stem does not end with a number.
std::optional<NumberedName> parse_stem(const std::string& stem);

}  // namespace tessera
