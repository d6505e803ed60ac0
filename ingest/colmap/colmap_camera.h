// What: COLMAP's camera models (3.8: numbers 0–10) → pinhole intrinsics and lens.
// Not: the files they are stored in (colmap_records.h).
#pragma once
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "ingest/poses/lens.h"
#include "kernels/base/camera.h"

namespace tessera {

struct ColmapCamera {
  std::string model;  // "OPENCV"
  Camera camera;      // size and intrinsics; no pose
  Lens lens;
};

struct ColmapCameraModel {
  int32_t number;
  const char* name;
  const char* parameters;  // in file order, blanks between them
  Lens::Projection projection;
  size_t parameter_count() const;
};

/// Errors: InputError that starts with `where` and lists the models there are.
const ColmapCameraModel& colmap_camera_model(int32_t number, const std::string& where);
const ColmapCameraModel& colmap_camera_model(const std::string& name, const std::string& where);

/// Errors: InputError that starts with `where`: a size or focal length that is not positive, a
/// parameter that is not finite, another number of parameters than the model has.
ColmapCamera make_colmap_camera(const ColmapCameraModel& model, uint64_t width, uint64_t height,
                                const std::vector<double>& parameters, const std::string& where);

/// The lens's parameters that are not zero, by COLMAP's names, in one fixed order.
std::vector<std::pair<const char*, double>> lens_parameters(const Lens& lens);

}  // namespace tessera
