// Reads a file of cameras (`--poses FILE`) as the cameras of the videos or photos of a rig, by
// name.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "ingest/poses/lens.h"

namespace tessera {

/// The camera of each of `names` (a video's file name without extension), in their order; cameras
/// of other names are passed over. `file` is one of
/// - poses_bounds.npy: row i is that of the i-th of `names`, which are sorted; no lens;
/// - JSON with a list `cameras` or `frames`, one entry a camera, called `name`, else by the camera
///   of a prepared scene, else by `file_path` without folder and extension. An entry has
///   `transform_matrix` (camera-to-world, OpenGL axes), or `R_w2c` and `t_w2c` (world to camera,
///   OpenCV axes). Its intrinsics and Nerfstudio's distortion keys (fl_x fl_y cx cy w h, k1 …; fx,
///   fy too) stand in the entry, else in the file or its object `intrinsics`; w and h are needed.
/// Sizes are those that the file states; camera_of_image() brings them to an image's. Errors:
/// InputError naming the file: no such format, names without a camera (all in one line), a camera
/// listed twice with different poses, another number of rows than of names.
std::vector<RigCamera> read_rig_cameras(const std::filesystem::path& file,
                                        const std::vector<std::string>& names);

/// As read_rig_cameras, but a name without a camera has none, and `missing`, empty otherwise, says
/// so in one line that names file and cameras and ends before the remedy.
std::vector<std::optional<RigCamera>> find_rig_cameras(const std::filesystem::path& file,
                                                       const std::vector<std::string>& names,
                                                       std::string& missing);
inline constexpr const char* kUnposedRemedy =
    "rename them alike, or leave those without a pose out of the capture";

/// `stated` for an image of width × height: scaled where the shape is the same. Where one side is
/// the same and the other up to 15 pixels shorter, the image was cut to it from whole 16-pixel
/// blocks, right or below: the intrinsics stay, in pixels. Errors: InputError that starts with
/// `where`: another shape.
Camera camera_of_image(const Camera& stated, int width, int height, const std::string& where);

}  // namespace tessera
