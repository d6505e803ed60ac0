// The table of the camera models of COLMAP 3.8. The name of each parameter determines its field of
// Lens or Camera.
#include "ingest/colmap/colmap_records.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <sstream>
#include <string_view>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

using enum Lens::Projection;

constexpr std::array<ColmapCameraModel, 11> kModels{
    {{0, "SIMPLE_PINHOLE", "f cx cy", kPinhole},
     {1, "PINHOLE", "fx fy cx cy", kPinhole},
     {2, "SIMPLE_RADIAL", "f cx cy k1", kPinhole},
     {3, "RADIAL", "f cx cy k1 k2", kPinhole},
     {4, "OPENCV", "fx fy cx cy k1 k2 p1 p2", kPinhole},
     {5, "OPENCV_FISHEYE", "fx fy cx cy k1 k2 k3 k4", kFisheye},
     {6, "FULL_OPENCV", "fx fy cx cy k1 k2 p1 p2 k3 d1 d2 d3", kPinhole},
     {7, "FOV", "fx fy cx cy omega", kFieldOfView},
     {8, "SIMPLE_RADIAL_FISHEYE", "f cx cy k1", kFisheye},
     {9, "RADIAL_FISHEYE", "f cx cy k1 k2", kFisheye},
     {10, "THIN_PRISM_FISHEYE", "fx fy cx cy k1 k2 p1 p2 k3 k4 s1 s2", kFisheye}}};

struct LensParameter {
  const char* name;
  double Lens::*member;
};
constexpr std::array<LensParameter, 12> kLensParameters{{{"k1", &Lens::k1},
                                                         {"k2", &Lens::k2},
                                                         {"k3", &Lens::k3},
                                                         {"k4", &Lens::k4},
                                                         {"d1", &Lens::d1},
                                                         {"d2", &Lens::d2},
                                                         {"d3", &Lens::d3},
                                                         {"p1", &Lens::p1},
                                                         {"p2", &Lens::p2},
                                                         {"s1", &Lens::s1},
                                                         {"s2", &Lens::s2},
                                                         {"omega", &Lens::omega}}};

std::vector<std::string> names_of(const char* parameters) {
  std::istringstream in(parameters);
  std::vector<std::string> names;
  for (std::string name; in >> name;) names.push_back(name);
  return names;
}

[[noreturn]] void fail_unknown(const std::string& where, const std::string& seen) {
  std::string known;
  for (const ColmapCameraModel& model : kModels)
    known += fmt::format("{}{} {}", known.empty() ? "" : ", ", model.number, model.name);
  throw InputError(fmt::format(
      "{}: camera model {} is unknown, expected one of {}; run `colmap "
      "image_undistorter` of the version that wrote it (3.12 for 11 and more) and use its "
      "result",
      where, seen, known));
}

void put(ColmapCamera& camera, const std::string& name, double value) {
  if (name == "f") camera.camera.fl_x = camera.camera.fl_y = value;
  if (name == "fx") camera.camera.fl_x = value;
  if (name == "fy") camera.camera.fl_y = value;
  if (name == "cx") camera.camera.cx = value;
  if (name == "cy") camera.camera.cy = value;
  for (const LensParameter& parameter : kLensParameters)
    if (name == parameter.name) camera.lens.*parameter.member = value;
}

}  // namespace

size_t ColmapCameraModel::parameter_count() const {
  return names_of(parameters).size();
}

const ColmapCameraModel& colmap_camera_model(int32_t number, const std::string& where) {
  for (const ColmapCameraModel& model : kModels)
    if (model.number == number) return model;
  fail_unknown(where, fmt::format("{}", number));
}

const ColmapCameraModel& colmap_camera_model(const std::string& name, const std::string& where) {
  for (const ColmapCameraModel& model : kModels)
    if (model.name == name) return model;
  fail_unknown(where, fmt::format("'{}'", name));
}

bool has_two_focal_lengths(const std::string& model) {
  return std::string_view(colmap_camera_model(model, "--camera-model").parameters)
      .starts_with("fx fy");
}

ColmapCamera make_colmap_camera(const ColmapCameraModel& model, uint64_t width, uint64_t height,
                                const std::vector<double>& parameters, const std::string& where) {
  constexpr uint64_t kLongestSide = 1 << 20;
  constexpr const char* kRemedy = "write the model again, or correct this camera";
  const auto names = names_of(model.parameters);
  if (width < 1 || height < 1 || width > kLongestSide || height > kLongestSide)
    throw InputError(
        fmt::format("{}: states an image of {}x{} pixels; {}", where, width, height, kRemedy));
  if (parameters.size() != names.size())
    throw InputError(fmt::format("{}: has {} parameters, {} has {} ({}); {}", where,
                                 parameters.size(), model.name, names.size(), model.parameters,
                                 kRemedy));
  ColmapCamera camera;
  camera.model = model.name;
  camera.lens.projection = model.projection;
  camera.camera.width = int(width);
  camera.camera.height = int(height);
  for (size_t i = 0; i < names.size(); ++i) {
    const bool is_focal = names[i].front() == 'f';
    if (!std::isfinite(parameters[i]) || (is_focal && parameters[i] <= 0))
      throw InputError(fmt::format(
          "{}: {} of {} is {}, expected {}; {}", where, names[i], model.name, parameters[i],
          is_focal ? "a positive number of pixels" : "a finite number", kRemedy));
    put(camera, names[i], parameters[i]);
  }
  return camera;
}

std::vector<std::pair<const char*, double>> lens_parameters(const Lens& lens) {
  std::vector<std::pair<const char*, double>> parameters;
  for (const LensParameter& parameter : kLensParameters)
    if (const double value = lens.*parameter.member; value != 0)
      parameters.emplace_back(parameter.name, value);
  return parameters;
}

}  // namespace tessera
