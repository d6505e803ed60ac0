// Converts rows to cameras: the OpenGL c2w is [col1, −col0, col2, centre]. The world is neither
// recentred nor rescaled. Source: LLFF (Mildenhall et al. 2019).
#include "ingest/poses/llff_poses.h"

#include <fmt/format.h>

#include <cmath>

#include "ingest/files/npy.h"
#include "ingest/poses/pose_matrix.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

constexpr int64_t kColumns = 17;

int pixels(double value, const std::string& where) {
  if (!(value >= 1 && value <= (1 << 20)))
    throw InputError(fmt::format(
        "{}: states an image size of {}, expected pixels; correct poses_bounds.npy", where, value));
  return int(std::lround(value));
}

}  // namespace

std::vector<LlffPose> read_llff_poses(const std::filesystem::path& path) {
  const Matrix table = read_npy(path);
  if (table.columns != kColumns)
    throw InputError(
        fmt::format("{}: has {} columns, expected 17 (LLFF); make it again with LLFF's imgs2poses",
                    path.string(), table.columns));
  std::vector<LlffPose> poses;
  for (int64_t row = 0; row < table.rows; ++row) {
    const std::string where = fmt::format("{}, row {}", path.string(), row);
    const auto value = [&](int r, int c) { return table(row, 5 * r + c); };
    PoseRows gl{};
    for (int r = 0; r < 3; ++r)
      gl[size_t(r)] = {value(r, 1), -value(r, 0), value(r, 2), value(r, 3)};
    LlffPose pose;
    set_pose(pose.camera, gl, where);
    pose.camera.height = pixels(value(0, 4), where);
    pose.camera.width = pixels(value(1, 4), where);
    pose.camera.fl_x = pose.camera.fl_y = value(2, 4);
    if (!std::isfinite(pose.camera.fl_x) || pose.camera.fl_x <= 0)
      throw InputError(fmt::format("{}: focal length is {}, expected pixels; correct it", where,
                                   pose.camera.fl_x));
    pose.camera.cx = 0.5 * pose.camera.width;
    pose.camera.cy = 0.5 * pose.camera.height;
    pose.near = table(row, 15);
    pose.far = table(row, 16);
    poses.push_back(pose);
  }
  return poses;
}

void write_llff_poses(const std::filesystem::path& path, const std::vector<LlffPose>& poses) {
  Matrix table{int64_t(poses.size()), kColumns, {}};
  table.data.resize(poses.size() * size_t(kColumns));
  for (int64_t row = 0; row < table.rows; ++row) {
    const LlffPose& pose = poses[size_t(row)];
    const PoseRows gl = gl_pose_of(pose.camera);
    const double size_and_focal[3] = {double(pose.camera.height), double(pose.camera.width),
                                      pose.camera.fl_x};
    for (int r = 0; r < 3; ++r) {
      const auto& [x, y, z, centre] = gl[size_t(r)];
      const double llff[5] = {-y, x, z, centre, size_and_focal[r]};
      for (int c = 0; c < 5; ++c) table(row, 5 * r + c) = llff[c];
    }
    table(row, 15) = pose.near;
    table(row, 16) = pose.far;
  }
  write_npy(path, table);
}

}  // namespace tessera
