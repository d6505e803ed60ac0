// What: Nerfstudio's camera models and distortion keys.
// Not: intrinsics (transforms_values.h). Source: Nerfstudio, data conventions; OpenCV's models.
#include "ingest/poses/stated_lens.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "ingest/poses/transforms_values.h"
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

/// What this level calls its camera; empty where it is silent.
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

}  // namespace

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
