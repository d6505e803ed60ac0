// Finds the keys, takes their numbers apart and turns OpenCV's conventions into those of Camera.
#include "ingest/poses/opencv_values.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <initializer_list>
#include <limits>
#include <nlohmann/json.hpp>
#include <vector>

#include "ingest/files/json_file.h"
#include "kernels/base/errors.h"
#include "kernels/base/lower_case.h"

namespace tessera {
namespace {

using nlohmann::json;
using Keys = std::initializer_list<const char*>;

constexpr Keys kMatrixKeys{"K",   "camera_matrix", "cameraMatrix", "CameraMatrix",
                           "mtx", "intrinsics"};
constexpr Keys kDistortionKeys{
    "D", "dist", "distCoeffs", "dist_coeffs", "distortion_coefficients", "Distortion_Coefficients"};
constexpr Keys kRotationKeys{"R_w2c", "R", "Rot", "rotation_matrix", "rvec", "Rvec"};
constexpr Keys kTranslationKeys{"t_w2c", "T_w2c", "T", "t", "tvec", "Tvec"};
constexpr Keys kPoseKeys{"w2c", "extrinsics", "extrinsic", "RT", "Rt"};

struct Stated {
  const char* key;
  const json* value;
  explicit operator bool() const { return value != nullptr; }
};

/// The first of `keys` that is there with a list or a matrix of OpenCV; without a value where none
/// is.
Stated find_matrix(const json& object, Keys keys) {
  for (const char* key : keys)
    if (const auto found = object.find(key);
        found != object.end() && (!found->is_object() || found->contains("data")))
      return {key, &*found};
  return {nullptr, nullptr};
}

void flatten(const json& value, std::vector<double>& all) {
  if (value.is_array())
    for (const json& cell : value) flatten(cell, all);
  else
    all.push_back(value.is_number() ? value.get<double>()
                                    : std::numeric_limits<double>::quiet_NaN());
}

/// So many finite numbers. Errors: InputError naming the key.
std::vector<double> numbers(const Stated& stated, const std::vector<size_t>& counts,
                            const std::string& where) {
  std::vector<double> all;
  flatten(stated.value->is_object() ? (*stated.value)["data"] : *stated.value, all);
  bool fits = std::find(counts.begin(), counts.end(), all.size()) != counts.end();
  for (const double value : all) fits = fits && std::isfinite(value);
  if (!fits)
    throw InputError(fmt::format("{}: {} is not {} finite numbers; correct this camera", where,
                                 stated.key, fmt::join(counts, " or ")));
  return all;
}

std::optional<int> whole_pixels(double value, const char* key, const std::string& where) {
  if (!(value >= 1 && value <= (1 << 20)) || value != std::floor(value))
    throw InputError(fmt::format("{}: {} is {}, expected a whole number of pixels; correct it",
                                 where, key, value));
  return int(value);
}

void read_size(const json& object, const std::string& where, StatedIntrinsics& stated) {
  for (const char* key : {"width", "image_width"})
    if (const auto value = finite_number(object, key, where))
      stated.w = whole_pixels(*value, key, where);
  for (const char* key : {"height", "image_height"})
    if (const auto value = finite_number(object, key, where))
      stated.h = whole_pixels(*value, key, where);
  const Stated size = find_matrix(object, {"imgsize", "imgSize", "image_size", "img_size"});
  if (!size) return;
  const std::vector<double> sides = numbers(size, {2}, where);
  stated.w = whole_pixels(sides[0], size.key, where);
  stated.h = whole_pixels(sides[1], size.key, where);
}

bool is_fisheye(const json& object, const std::string& where) {
  for (const char* key : {"is_fisheye", "fisheye", "fisheye_model"})
    if (const auto found = object.find(key); found != object.end())
      if (is_true(object, key) || (found->is_number() && found->get<double>() != 0)) return true;
  return lower_case(string_at(object, "camera_model", where)).find("fisheye") != std::string::npos;
}

using Rows = std::array<std::array<double, 4>, 3>;  // rotation | translation

std::vector<double> rotation_of(const std::vector<double>& stated) {
  if (stated.size() == 9) return stated;
  const glm::dvec3 vector(stated[0], stated[1], stated[2]);
  const double angle = glm::length(vector);
  const glm::dmat3 rotation =
      angle == 0 ? glm::dmat3(1) : glm::mat3_cast(glm::angleAxis(angle, vector / angle));
  std::vector<double> rows;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) rows.push_back(rotation[c][r]);
  return rows;
}

/// R and T beside each other; nothing where neither is there.
std::optional<Rows> parts(const json& object, Keys rotation_keys, Keys translation_keys,
                          const std::string& where) {
  const Stated rotation = find_matrix(object, rotation_keys);
  const Stated translation = find_matrix(object, translation_keys);
  if (!rotation && !translation) return std::nullopt;
  if (!rotation)
    throw InputError(
        fmt::format("{}: has {} and no rotation; add R (3x3) or rvec", where, translation.key));
  const std::string key = rotation.key;
  const std::vector<size_t> counts = key.starts_with("R_")       ? std::vector<size_t>{9}
                                     : lower_case(key) == "rvec" ? std::vector<size_t>{3}
                                                                 : std::vector<size_t>{9, 3};
  const std::vector<double> r = rotation_of(numbers(rotation, counts, where));
  if (!translation)
    throw InputError(fmt::format("{}: has {} and no translation; add {}", where, key,
                                 key.starts_with("R_") ? *translation_keys.begin() : "T"));
  const std::vector<double> t = numbers(translation, {3}, where);
  Rows rows{};
  for (size_t i = 0; i < 3; ++i) rows[i] = {r[3 * i], r[3 * i + 1], r[3 * i + 2], t[i]};
  return rows;
}

/// One matrix of 3x4 or 4x4; nothing where none is there.
std::optional<Rows> whole(const json& object, Keys keys, const std::string& where) {
  const Stated matrix = find_matrix(object, keys);
  if (!matrix) return std::nullopt;
  const std::vector<double> values = numbers(matrix, {12, 16}, where);
  if (values.size() == 16 &&
      (values[12] != 0 || values[13] != 0 || values[14] != 0 || values[15] != 1))
    throw InputError(fmt::format(
        "{}: the last row of {} is not 0 0 0 1; write the matrix row by row", where, matrix.key));
  Rows rows{};
  for (size_t i = 0; i < 12; ++i) rows[i / 4][i % 4] = values[i];
  return rows;
}

/// x_cam = R x + t in OpenCV axes as OpenGL's camera-to-world.
PoseRows gl_rows_of_world_to_camera(const Rows& w2c) {
  PoseRows rows{};
  for (size_t axis = 0; axis < 3; ++axis) {
    double centre = 0;
    for (size_t k = 0; k < 3; ++k) centre -= w2c[k][axis] * w2c[k][3];
    rows[axis] = {w2c[0][axis], -w2c[1][axis], -w2c[2][axis], centre};
  }
  return rows;
}

PoseRows gl_rows_of_camera_to_world(Rows c2w) {
  for (auto& row : c2w) {
    row[1] = -row[1];
    row[2] = -row[2];
  }
  return c2w;
}

}  // namespace

StatedIntrinsics opencv_intrinsics(const json& object, const std::string& where) {
  StatedIntrinsics stated;
  read_size(object, where, stated);
  const Stated matrix = find_matrix(object, kMatrixKeys);
  if (!matrix) return stated;
  const std::vector<double> k = numbers(matrix, {9}, where);
  const double tolerance = 1e-6 * std::abs(k[0]);
  if (std::abs(k[1]) > tolerance || k[3] != 0 || k[6] != 0 || k[7] != 0 || k[8] != 1)
    throw InputError(fmt::format(
        "{}: {} is no camera matrix [fx 0 cx; 0 fy cy; 0 0 1] (no skew, row by row); correct it",
        where, matrix.key));
  stated.fl_x = k[0];
  stated.fl_y = k[4];
  stated.cx = k[2] + 0.5;
  stated.cy = k[5] + 0.5;
  return stated;
}

std::optional<StatedLens> opencv_lens(const json& entry, const json& file,
                                      const std::string& where) {
  const Stated of_entry = find_matrix(entry, kDistortionKeys);
  const Stated stated = of_entry ? of_entry : find_matrix(file, kDistortionKeys);
  if (!stated) return std::nullopt;
  StatedLens lens;
  if (is_fisheye(entry, where) || is_fisheye(file, where)) {
    const std::vector<double> d = numbers(stated, {4}, where);
    lens.lens.projection = Lens::Projection::kFisheye;
    lens.lens.k1 = d[0], lens.lens.k2 = d[1], lens.lens.k3 = d[2], lens.lens.k4 = d[3];
    lens.model = "OPENCV_FISHEYE";
    return lens;
  }
  std::vector<double> d = numbers(stated, {4, 5, 8, 12, 14}, where);
  d.resize(14, 0);
  for (size_t i = 8; i < d.size(); ++i)
    if (d[i] != 0)
      throw InputError(fmt::format(
          "{}: {} has thin-prism or tilt coefficients, which are not supported; undistort the "
          "images, or calibrate with 8 coefficients",
          where, stated.key));
  Lens& l = lens.lens;
  l.k1 = d[0], l.k2 = d[1], l.p1 = d[2], l.p2 = d[3], l.k3 = d[4];
  l.d1 = d[5], l.d2 = d[6], l.d3 = d[7];
  const bool is_full = l.k3 != 0 || l.d1 != 0 || l.d2 != 0 || l.d3 != 0;
  lens.model = l.is_pinhole() ? "PINHOLE" : is_full ? "FULL_OPENCV" : "OPENCV";
  return lens;
}

std::optional<PoseRows> opencv_pose(const json& object, const std::string& where) {
  if (const auto rows = parts(object, kRotationKeys, kTranslationKeys, where))
    return gl_rows_of_world_to_camera(*rows);
  if (const auto rows = whole(object, kPoseKeys, where)) return gl_rows_of_world_to_camera(*rows);
  if (const auto rows = parts(object, {"R_c2w"}, {"t_c2w", "T_c2w"}, where))
    return gl_rows_of_camera_to_world(*rows);
  if (const auto rows = whole(object, {"c2w"}, where)) return gl_rows_of_camera_to_world(*rows);
  return std::nullopt;
}

}  // namespace tessera
