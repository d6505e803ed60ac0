// Reads the entries of a file of cameras, and scales intrinsics.
#include "ingest/poses/rig_poses_file.h"

#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "ingest/poses/camera_entries.h"
#include "ingest/poses/opencv_values.h"
#include "ingest/poses/transforms_values.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

using nlohmann::json;
using std::filesystem::path;

StatedIntrinsics intrinsics_at(const StatedObject& object) {
  StatedIntrinsics stated = intrinsics_of(object);
  if (!stated.fl_x) stated.fl_x = object.number("fx");
  if (!stated.fl_y) stated.fl_y = object.number("fy");
  return stated.or_else(opencv_intrinsics(object));
}

/// Errors: InputError: no focal length; no size, which alone K and a principal point do without.
void put_intrinsics(Camera& camera, const StatedIntrinsics& stated, const std::string& where) {
  if (!stated.fl_x && !stated.camera_angle_x)
    throw InputError(fmt::format(
        "{}: has no focal length; add K (the camera matrix of OpenCV) or fl_x, in pixels", where));
  const bool needs_no_size = stated.fl_x && stated.cx && stated.cy && !stated.w && !stated.h;
  if (needs_no_size) {
    set_intrinsics(camera, stated, 1, 1, where);
    camera.width = camera.height = 0;
    return;
  }
  if (!stated.w || !stated.h)
    throw InputError(
        fmt::format("{}: no image size; add w and h, which its intrinsics belong to", where));
  set_intrinsics(camera, stated, *stated.w, *stated.h, where);
}

PoseRows pose_at(const StatedObject& entry) {
  if (entry.has("transform_matrix") && !entry.has("R_w2c")) return pose_rows(entry);
  if (const auto rows = opencv_pose(entry)) return *rows;
  throw InputError(fmt::format(
      "{}: has no pose; add R and T (world to camera, as OpenCV has them) or transform_matrix",
      entry.where()));
}

RigCamera parse_camera(const CameraEntry& entry, const StatedObject& shared,
                       std::set<std::string>& unread) {
  const StatedObject values(entry.values, entry.where);
  for (const char* key : {"name", "file_path", "tessera"}) values.take(key);
  RigCamera camera;
  camera.name = entry.name;
  put_intrinsics(camera.camera, intrinsics_at(values).or_else(intrinsics_at(shared)), entry.where);
  set_pose(camera.camera, pose_at(values), entry.where);
  const auto opencv = opencv_lens(values, shared);
  const StatedLens lens = opencv ? *opencv : stated_lens(values, shared);
  camera.lens = lens.lens;
  camera.lens_model = lens.model;
  account_for(values, unread);
  return camera;
}

/// A camera whose size is not stated.
Camera camera_in_size(const Camera& stated, int width, int height, const std::string& where) {
  const auto is_off = [](double place, int side) {
    return !(3 * place >= side && 3 * place <= 2 * double(side));
  };
  if (is_off(stated.cx, width) || is_off(stated.cy, height))
    throw InputError(fmt::format(
        "{}: the image is {}x{}, the principal point of its camera is {:.1f}, {:.1f}, and no image "
        "size is stated; add the size of the images it was calibrated with (w and h)",
        where, width, height, stated.cx, stated.cy));
  Camera camera = stated;
  camera.width = width;
  camera.height = height;
  return camera;
}

}  // namespace

std::vector<RigCamera> rig_cameras_of(const json& file, const path& path,
                                      std::vector<std::string>& notes) {
  const std::string where = path.string();
  const CameraEntries found = camera_entries(file, path);
  const StatedObject shared(found.shared, where);
  std::vector<RigCamera> cameras;
  std::map<std::string, size_t> places;
  std::set<std::string> unread;
  for (const CameraEntry& entry : found.entries) {
    RigCamera camera = parse_camera(entry, shared, unread);
    const auto [known, is_new] = places.emplace(camera.name, cameras.size());
    if (is_new)
      cameras.push_back(std::move(camera));
    else if (!equal_pose(cameras[known->second].camera, camera.camera))
      throw InputError(fmt::format(
          "{}: lists camera '{}' with different poses; a rig's camera has one: remove the others",
          where, camera.name));
  }
  account_for(shared, unread);
  note_unread_keys(where, unread, notes);
  return cameras;
}

Camera camera_of_image(const Camera& stated, int width, int height, int shown_width,
                       const std::string& where) {
  if (stated.width == 0) return camera_in_size(stated, width, height, where);
  if (same_shape(stated.width, stated.height, width, height) ||
      same_shape(stated.width, stated.height, shown_width, height))
    return stated.resized(width, height);
  constexpr int kBlock = 16;  // pixels a side, of H.264; others' blocks are multiples of 8
  const int less_x = stated.width - width, less_y = stated.height - height;
  const bool cut = less_x >= 0 && less_y >= 0 && less_x < kBlock && less_y < kBlock &&
                   (less_x == 0 || less_y == 0);
  if (!cut)
    throw InputError(fmt::format(
        "{}: the image is {}x{}, its camera was calibrated at {}x{}; use images of that shape, "
        "or correct the camera",
        where, width, height, stated.width, stated.height));
  Camera camera = stated;
  camera.width = width;
  camera.height = height;
  return camera;
}

}  // namespace tessera
