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
#include <string_view>
#include <vector>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

using nlohmann::json;
using Names = std::initializer_list<std::string_view>;
using Stated = StatedObject::Member;

const Names kMatrixNames{"k",   "cameramatrix", "intrinsicmatrix", "kmatrix",
                         "mtx", "intrinsics",   "intrinsic"};
const Names kRotationNames{"rw2c", "r", "rot", "rotation", "rotationmatrix", "rvec"};
const Names kTranslationNames{"tw2c", "t", "trans", "translation", "tvec", "translationvector"};
const Names kPoseNames{"w2c", "extrinsics", "extrinsic", "extrinsicmatrix", "rt", "worldtocamera"};

/// The first of `names` that is there with a list or a matrix of OpenCV; without a value where none
/// is.
Stated find_matrix(const StatedObject& object, Names names) {
  for (const std::string_view name : names)
    if (Stated found = object.named({name}); found)
      if (!found.value->is_object() || found.value->contains("data")) return found;
  return {};
}

/// A list of coefficients, whatever follows "dist" in its key that speaks of them.
Stated find_distortion(const StatedObject& object) {
  return object.first([](const std::string& key, const json& value) {
    const std::string rest = key.starts_with("dist") ? key.substr(4) : "no";
    const bool speaks = rest.empty() || rest.starts_with("ortion") || rest.starts_with("coef") ||
                        rest.starts_with("param") || rest.starts_with("vec");
    return (key == "d" || speaks) && (value.is_array() || value.is_object());
  });
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
  const bool is_stored = stated.value->is_object() && stated.value->contains("data");
  flatten(is_stored ? (*stated.value)["data"] : *stated.value, all);
  bool fits = std::find(counts.begin(), counts.end(), all.size()) != counts.end();
  for (const double value : all) fits = fits && std::isfinite(value);
  if (!fits)
    throw InputError(fmt::format("{}: {} is not {} finite numbers; correct this camera", where,
                                 stated.key, fmt::join(counts, " or ")));
  return all;
}

int whole_pixels(double value, const std::string& key, const std::string& where) {
  if (!(value >= 1 && value <= (1 << 20)) || value != std::floor(value))
    throw InputError(fmt::format("{}: {} is {}, expected a whole number of pixels; correct it",
                                 where, key, value));
  return int(value);
}

void read_size(const StatedObject& object, StatedIntrinsics& stated) {
  const auto side = [&](Names names, std::optional<int>& to) {
    if (const Stated found = object.named(names); found && !found.value->is_array())
      to = whole_pixels(*object.number(found.key), found.key, object.where());
  };
  side({"width", "imagewidth"}, stated.w);
  side({"height", "imageheight"}, stated.h);
  const Stated size = find_matrix(object, {"imgsize", "imagesize", "framesize", "resolution"});
  if (!size) return;
  const std::vector<double> sides = numbers(size, {2}, object.where());
  stated.w = whole_pixels(sides[0], size.key, object.where());
  stated.h = whole_pixels(sides[1], size.key, object.where());
}

/// Whether one of the keys of a projection says so; a projection that is neither a pinhole with
/// OpenCV's coefficients nor cv::fisheye is refused.
bool is_fisheye(const StatedObject& object) {
  bool fisheye = false;
  for (const std::string_view name : {"isfisheye", "fisheye", "fisheyemodel"})
    if (const Stated found = object.named({name}); found)
      fisheye = fisheye || (found.value->is_number() ? *found.value != 0 : *found.value == true);
  for (const std::string_view name :
       {"cameramodel", "distortionmodel", "lensmodel", "projection", "projectionmodel",
        "projectiontype", "cameratype", "distortiontype", "lenstype"}) {
    const Stated found = object.named({name});
    if (!found || !found.value->is_string()) continue;
    const std::string model = plain_key(found.value->get<std::string>());
    constexpr std::array<std::string_view, 4> kFisheye{"equidistant", "kannalabrandt",
                                                       "kannalabrandt4", "kb4"};
    constexpr std::array<std::string_view, 15> kPerspective{"",
                                                            "none",
                                                            "perspective",
                                                            "pinhole",
                                                            "simplepinhole",
                                                            "simpleradial",
                                                            "radial",
                                                            "opencv",
                                                            "fullopencv",
                                                            "brown",
                                                            "brownconrady",
                                                            "plumbbob",
                                                            "radtan",
                                                            "radialtangential",
                                                            "rationalpolynomial"};
    const auto is_one_of = [&](const auto& models) {
      return std::find(models.begin(), models.end(), model) != models.end();
    };
    if (model.find("fisheye") != std::string::npos || is_one_of(kFisheye))
      fisheye = true;
    else if (!is_one_of(kPerspective))
      throw InputError(fmt::format(
          "{}: {} '{}' is not supported; there are a pinhole with OpenCV's coefficients and its "
          "fisheye: undistort the images with the program that calibrated them",
          object.where(), found.key, found.value->get<std::string>()));
  }
  return fisheye;
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
std::optional<Rows> parts(const StatedObject& object, Names rotation_names,
                          Names translation_names) {
  const std::string& where = object.where();
  const Stated rotation = find_matrix(object, rotation_names);
  const Stated translation = find_matrix(object, translation_names);
  if (!rotation && !translation) return std::nullopt;
  if (!rotation)
    throw InputError(
        fmt::format("{}: has {} and no rotation; add R (3x3) or rvec", where, translation.key));
  const std::string& key = rotation.key;
  const std::string name = plain_key(key);
  const bool is_directed = name == "rw2c" || name == "rc2w";
  const std::vector<size_t> counts = is_directed      ? std::vector<size_t>{9}
                                     : name == "rvec" ? std::vector<size_t>{3}
                                                      : std::vector<size_t>{9, 3};
  const std::vector<double> r = rotation_of(numbers(rotation, counts, where));
  if (!translation)
    throw InputError(fmt::format("{}: has {} and no translation; add {}", where, key,
                                 is_directed ? "t_" + key.substr(2) : "T"));
  const std::vector<double> t = numbers(translation, {3}, where);
  Rows rows{};
  for (size_t i = 0; i < 3; ++i) rows[i] = {r[3 * i], r[3 * i + 1], r[3 * i + 2], t[i]};
  return rows;
}

/// One matrix of 3x4 or 4x4; nothing where none is there.
std::optional<Rows> whole(const StatedObject& object, Names names) {
  const Stated matrix = find_matrix(object, names);
  if (!matrix) return std::nullopt;
  const std::string& where = object.where();
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

StatedIntrinsics opencv_intrinsics(const StatedObject& object) {
  StatedIntrinsics stated;
  read_size(object, stated);
  const Stated matrix = find_matrix(object, kMatrixNames);
  if (!matrix) return stated;
  const std::string& where = object.where();
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

std::optional<StatedLens> opencv_lens(const StatedObject& entry, const StatedObject& file) {
  const std::string& where = entry.where();
  const Stated of_entry = find_distortion(entry);
  const Stated stated = of_entry ? of_entry : find_distortion(file);
  if (!stated) return std::nullopt;
  StatedLens lens;
  if (stated.value->empty()) return lens;
  const bool of_entry_fisheye = is_fisheye(entry);
  if (is_fisheye(file) || of_entry_fisheye) {
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

std::optional<PoseRows> opencv_pose(const StatedObject& object) {
  if (const auto rows = parts(object, kRotationNames, kTranslationNames))
    return gl_rows_of_world_to_camera(*rows);
  if (const auto rows = whole(object, kPoseNames)) return gl_rows_of_world_to_camera(*rows);
  if (const auto rows = parts(object, {"rc2w"}, {"tc2w"})) return gl_rows_of_camera_to_world(*rows);
  if (const auto rows = whole(object, {"c2w", "cameratoworld"}))
    return gl_rows_of_camera_to_world(*rows);
  return std::nullopt;
}

}  // namespace tessera
