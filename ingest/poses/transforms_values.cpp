// Checks the types and ranges of the values of a transforms file, and maps the camera models of
// Nerfstudio to Lens.
#include "ingest/poses/transforms_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/matrix.hpp>
#include <nlohmann/json.hpp>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

using nlohmann::json;

struct Coefficient {
  const char* key;
  double Lens::*member;
};
constexpr std::array<Coefficient, 6> kCoefficients{{{"k1", &Lens::k1},
                                                    {"k2", &Lens::k2},
                                                    {"k3", &Lens::k3},
                                                    {"k4", &Lens::k4},
                                                    {"p1", &Lens::p1},
                                                    {"p2", &Lens::p2}}};
constexpr std::array kPerspective{"PINHOLE", "SIMPLE_PINHOLE", "SIMPLE_RADIAL", "RADIAL", "OPENCV"};
constexpr std::array kFisheye{"OPENCV_FISHEYE", "RADIAL_FISHEYE", "SIMPLE_RADIAL_FISHEYE"};

constexpr const char* kRemedy =
    "undistort the images with the program that calibrated them (for instance `colmap "
    "image_undistorter`) and state a pinhole camera";

bool states_coefficients(const json& object) {
  return std::any_of(kCoefficients.begin(), kCoefficients.end(),
                     [&](const Coefficient& each) { return object.contains(each.key); });
}

/// The camera model that this level states; empty where there is none.
std::string model_of(const json& object, const std::string& where) {
  const std::string stated = string_at(object, "camera_model", where);
  return stated.empty() && is_true(object, "is_fisheye") ? "OPENCV_FISHEYE" : stated;
}

void refuse_coefficient(const Lens& lens, double Lens::*member, const char* key, const char* kind,
                        const std::string& where) {
  if (lens.*member != 0)
    throw InputError(fmt::format("{}: {} = {} is not supported for a {} camera; {}", where, key,
                                 lens.*member, kind, kRemedy));
}

std::optional<int> pixels_at(const json& object, const char* key, const std::string& where) {
  const auto value = finite_number(object, key, where);
  if (!value) return std::nullopt;
  if (*value < 1 || *value > (1 << 20) || *value != double(int(*value)))
    throw InputError(fmt::format("{}: {} is {}, expected a whole number of pixels; correct it",
                                 where, key, *value));
  return int(*value);
}

}  // namespace

bool is_true(const json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_boolean() && found->get<bool>();
}

StatedIntrinsics intrinsics_of(const json& object, const std::string& where) {
  StatedIntrinsics stated;
  stated.fl_x = finite_number(object, "fl_x", where);
  stated.fl_y = finite_number(object, "fl_y", where);
  stated.cx = finite_number(object, "cx", where);
  stated.cy = finite_number(object, "cy", where);
  stated.camera_angle_x = finite_number(object, "camera_angle_x", where);
  stated.camera_angle_y = finite_number(object, "camera_angle_y", where);
  stated.w = pixels_at(object, "w", where);
  stated.h = pixels_at(object, "h", where);
  return stated;
}

void refuse_distortion(const json& object, const std::string& where) {
  constexpr const char* kRemedy =
      "run `tessera ingest`, which undistorts the images, and open its result";
  for (const char* key : {"k1", "k2", "k3", "k4", "k5", "k6", "p1", "p2"})
    if (const auto value = finite_number(object, key, where); value.value_or(0) != 0)
      throw InputError(
          fmt::format("{}: lens distortion {} = {} is not supported, expected "
                      "pinhole images; {}",
                      where, key, *value, kRemedy));
  const bool fisheye =
      is_true(object, "is_fisheye") ||
      string_at(object, "camera_model", where).find("FISHEYE") != std::string::npos;
  if (fisheye)
    throw InputError(fmt::format(
        "{}: fisheye cameras are not supported, expected pinhole images; {}", where, kRemedy));
}

PoseRows pose_rows(const json& frame, const std::string& where) {
  const auto matrix = frame.find("transform_matrix");
  const bool has_rows =
      matrix != frame.end() && matrix->is_array() && (matrix->size() == 3 || matrix->size() == 4) &&
      std::all_of(matrix->begin(), matrix->end(),
                  [](const json& row) { return row.is_array() && row.size() == 4; });
  if (!has_rows)
    throw InputError(fmt::format(
        "{}: transform_matrix is missing or not 4x4; add the camera-to-world matrix", where));
  PoseRows rows{};
  for (size_t r = 0; r < 3; ++r)
    for (size_t c = 0; c < 4; ++c) {
      const json& value = (*matrix)[r][c];
      if (!value.is_number())
        throw InputError(fmt::format(
            "{}: transform_matrix has {} in row {}, column {}; correct this pose or remove the "
            "frame",
            where, value.is_null() ? "NaN, an infinity or null" : value.type_name(), r, c));
      rows[r][c] = value.get<double>();
    }
  return rows;
}

Similarity world_transform_of(const json& object, const std::string& where) {
  const auto applied = object.find("applied");
  if (applied == object.end() || !applied->contains("world_transform")) return {};
  const std::string place = where + ": tessera.applied.world_transform";
  const PoseRows rows = pose_rows({{"transform_matrix", (*applied)["world_transform"]}}, place);
  Similarity world;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) world.rotation[c][r] = rows[size_t(r)][size_t(c)];
    world.translation[r] = rows[size_t(r)][3];
  }
  world.scale = std::cbrt(glm::determinant(world.rotation));
  world.rotation /= world.scale;
  const glm::dmat3 residual = glm::transpose(world.rotation) * world.rotation - glm::dmat3(1.0);
  for (int c = 0; c < 3; ++c)
    if (!(world.scale > 0) || !(glm::length(residual[c]) < 1e-9))
      throw InputError(
          fmt::format("{} is no rotation times a scale above 0; prepare the capture again", place));
  return world;
}

StatedLens stated_lens(const json& frame, const json& file, const std::string& where) {
  StatedLens stated;
  const std::string of_frame = model_of(frame, where);
  const std::string model = of_frame.empty() ? model_of(file, where) : of_frame;
  const json& level = states_coefficients(frame) ? frame : file;
  for (const Coefficient& each : kCoefficients)
    stated.lens.*each.member = finite_number(level, each.key, where).value_or(0);
  for (const json* each : {&frame, &file})
    for (const char* key : {"k5", "k6"})
      if (finite_number(*each, key, where).value_or(0) != 0)
        throw InputError(fmt::format("{}: {} is not supported; {}", where, key, kRemedy));
  const auto is_one_of = [&](const auto& names) {
    return std::find(names.begin(), names.end(), model) != names.end();
  };
  if (is_one_of(kFisheye)) {
    stated.lens.projection = Lens::Projection::kFisheye;
    refuse_coefficient(stated.lens, &Lens::p1, "p1", "fisheye", where);
    refuse_coefficient(stated.lens, &Lens::p2, "p2", "fisheye", where);
  } else if (model.empty() || is_one_of(kPerspective)) {
    refuse_coefficient(stated.lens, &Lens::k4, "k4", "perspective", where);
  } else {
    throw InputError(fmt::format("{}: camera_model '{}' is not supported, there are {}, {}; {}",
                                 where, model, fmt::join(kPerspective, ", "),
                                 fmt::join(kFisheye, ", "), kRemedy));
  }
  if (!stated.lens.is_pinhole())
    stated.model = model.empty() || model.ends_with("PINHOLE") ? "OPENCV" : model;
  return stated;
}

}  // namespace tessera
