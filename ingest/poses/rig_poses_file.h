// Reads a JSON file of cameras, as other programs, OpenCV and people write it, and fits a stated
// camera to the size of its image.
#pragma once
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "ingest/poses/lens.h"

namespace tessera {

/// The cameras of a JSON tree (camera_entries.h), each once, in its order. An entry has
/// - `transform_matrix` (camera-to-world, OpenGL axes), or R and T of OpenCV (opencv_values.h);
/// - intrinsics and Nerfstudio's distortion keys (fl_x fl_y cx cy w h, k1 …; fx, fy too), or K and
/// D
///   of OpenCV, in itself, else in the file or its object `intrinsics`. The width and the height
///   are 0 where focal lengths and principal point are stated without a size.
/// Sizes are those that the file states; camera_of_image() brings them to an image's. Errors:
/// InputError naming file and camera: no such form, a value that cannot be, no focal length, no
/// pose, a camera listed twice with different poses, a key that speaks of a lens or a pose and is
/// not understood. `notes` gets a line of other keys that are not read.
std::vector<RigCamera> rig_cameras_of(const nlohmann::json& file, const std::filesystem::path& path,
                                      std::vector<std::string>& notes);

/// `stated` for an image of width × height: scaled where the shape is the same, or that of the
/// image as it is shown (`shown_width` × height, of anamorphic video). Where one side is the same
/// and the other up to 15 pixels shorter, the image was cut to it from whole 16-pixel blocks, right
/// or below: the intrinsics stay, in pixels. Without a stated size they are those of this image.
/// Errors: InputError that starts with `where`: another shape; without a size a principal point
/// outside of the middle third, which is that of another size.
Camera camera_of_image(const Camera& stated, int width, int height, int shown_width,
                       const std::string& where);

}  // namespace tessera
