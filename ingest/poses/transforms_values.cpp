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

bool states_coefficients(const StatedObject& object) {
  return std::any_of(kCoefficients.begin(), kCoefficients.end(),
                     [&](const Coefficient& each) { return object.has(each.key); });
}

/// The camera model that this level states; empty where there is none.
std::string model_of(const StatedObject& object) {
  const std::string stated = object.text("camera_model");
  return object.is_true("is_fisheye") && stated.empty() ? "OPENCV_FISHEYE" : stated;
}

void refuse_coefficient(const Lens& lens, double Lens::*member, const char* key, const char* kind,
                        const std::string& where) {
  if (lens.*member != 0)
    throw InputError(fmt::format("{}: {} = {} is not supported for a {} camera; {}", where, key,
                                 lens.*member, kind, kRemedy));
}

std::optional<int> pixels_at(const StatedObject& object, const char* key) {
  const auto value = object.number(key);
  if (!value) return std::nullopt;
  if (*value < 1 || *value > (1 << 20) || *value != double(int(*value)))
    throw InputError(fmt::format("{}: {} is {}, expected a whole number of pixels; correct it",
                                 object.where(), key, *value));
  return int(*value);
}

}  // namespace

StatedIntrinsics intrinsics_of(const StatedObject& object) {
  StatedIntrinsics stated;
  stated.fl_x = object.number("fl_x");
  stated.fl_y = object.number("fl_y");
  stated.cx = object.number("cx");
  stated.cy = object.number("cy");
  stated.camera_angle_x = object.number("camera_angle_x");
  stated.camera_angle_y = object.number("camera_angle_y");
  stated.w = pixels_at(object, "w");
  stated.h = pixels_at(object, "h");
  const auto readout = object.named({"readout", "rollingshutter", "rollingshuttertime"});
  if (readout && readout.value->is_number()) stated.readout = object.number(readout.key);
  return stated;
}

void refuse_distortion(const StatedObject& object) {
  constexpr const char* kPrepare =
      "run `tessera ingest`, which undistorts the images, and open its result";
  for (const char* key : {"k1", "k2", "k3", "k4", "k5", "k6", "p1", "p2"})
    if (const auto value = object.number(key); value.value_or(0) != 0)
      throw InputError(
          fmt::format("{}: lens distortion {} = {} is not supported, expected "
                      "pinhole images; {}",
                      object.where(), key, *value, kPrepare));
  const bool fisheye = object.text("camera_model").find("FISHEYE") != std::string::npos;
  if (object.is_true("is_fisheye") || fisheye)
    throw InputError(
        fmt::format("{}: fisheye cameras are not supported, expected pinhole images; {}",
                    object.where(), kPrepare));
}

PoseRows pose_rows(const StatedObject& frame, const char* key) {
  const std::string& where = frame.where();
  const json* const matrix = frame.at(key);
  const bool has_rows =
      matrix != nullptr && matrix->is_array() && (matrix->size() == 3 || matrix->size() == 4) &&
      std::all_of(matrix->begin(), matrix->end(),
                  [](const json& row) { return row.is_array() && row.size() == 4; });
  if (!has_rows)
    throw InputError(
        fmt::format("{}: {} is missing or not 4x4; add the camera-to-world matrix", where, key));
  std::array<std::array<double, 4>, 4> values{{{}, {}, {}, {0, 0, 0, 1}}};
  for (size_t r = 0; r < matrix->size(); ++r)
    for (size_t c = 0; c < 4; ++c) {
      const json& value = (*matrix)[r][c];
      if (!value.is_number())
        throw InputError(fmt::format(
            "{}: {} has {} in row {}, column {}; correct this pose or remove the frame", where, key,
            value.is_null() ? "NaN, an infinity or null" : value.type_name(), r, c));
      values[r][c] = value.get<double>();
    }
  constexpr double kRounding = 1e-6;
  for (size_t c = 0; c < 4; ++c)
    if (!(std::abs(values[3][c] - (c == 3 ? 1 : 0)) < kRounding))
      throw InputError(fmt::format(
          "{}: the last row of {} is {}, expected 0, 0, 0, 1; write the matrix row by row, with "
          "the place of the camera in its last column",
          where, key, fmt::join(values[3], ", ")));
  return {values[0], values[1], values[2]};
}

Similarity world_transform_of(const json& object, const std::string& where) {
  const auto applied = object.find("applied");
  if (applied == object.end() || !applied->contains("world_transform")) return {};
  const std::string place = where + ": tessera.applied.world_transform";
  const PoseRows rows = pose_rows({*applied, where + ": tessera.applied"}, "world_transform");
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

StatedLens stated_lens(const StatedObject& frame, const StatedObject& file) {
  const std::string& where = frame.where();
  StatedLens stated;
  const std::string of_frame = model_of(frame), of_file = model_of(file);
  const std::string& model = of_frame.empty() ? of_file : of_frame;
  const StatedObject& level = states_coefficients(frame) ? frame : file;
  for (const Coefficient& each : kCoefficients)
    stated.lens.*each.member = level.number(each.key).value_or(0);
  for (const StatedObject* each : {&frame, &file})
    for (const char* key : {"k5", "k6"})
      if (each->number(key).value_or(0) != 0)
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
