// A clip for the tests of line formats.
#pragma once
#include <cmath>
#include <filesystem>
#include <string>

#include "kernels/math/spherical_harmonics.h"
#include "static3d/formats/splat_file.h"
#include "static3d/line_motion/line_formats.h"
#include "static3d/line_motion/line_model.h"
#include "tests/recon4d/model/small_models.h"

namespace tessera::testing {

/// Static Gaussians and `moving` others, of a clip of 5 s from 2 s on, with rules of its own.
inline GaussianModel some_clip(int coefficients = 16, int64_t still = 3, int64_t moving = 7) {
  GaussianModel model = random_model(still, moving, 4, coefficients, SetForm::kVelocity);
  const GaussianSpans<float> values = model.dynamic_set.values();
  for (int64_t n = 0; n < values.count; ++n) {
    *values.at(kMeanTime, n) = float(double(n) / double(moving - 1));
    *values.at(kLogScaleTime, n) = float(std::log(0.05 + 0.05 * double(n % 7)));
  }
  for (GaussianSet* set : {&model.static_set, &model.dynamic_set}) normalise_rotations(*set);
  model.drawing.filter_2d = true;
  model.drawing.near_plane = 0.125;
  model.drawing.sh_degree = sh_degree_of(coefficients);
  model.time_axis = {2, 5};
  model.background = {10, 20, 255};
  return model;
}

/// In the format that the name of the file ends with.
inline int64_t save_lines(const std::filesystem::path& path, const GaussianModel& model,
                          double fps = 0) {
  const WindowModels whole{{FileWindow{}}, [&](int) { return model.clone_values(); }};
  int64_t left_out = -1;
  for (const LineFormat& format : line_formats())
    if (path.filename().string().ends_with(format.extension))
      left_out = format.save(path, line_model(whole, model), fps);
  return left_out;
}

}  // namespace tessera::testing
