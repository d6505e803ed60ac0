// What: the mean colour of the training images, all around.
// Not: a guess of the sky from them.
#include "recon4d/training/environment.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "kernels/base/errors.h"
#include "kernels/math/environment.h"

namespace tessera {
namespace {

/// Of the pixels that masks use; grey where there are none.
std::array<float, 3> mean_colour(const Scene& scene) {
  std::array<double, 3> sum{};
  double pixels = 0;
  for (const int f : scene.split_indices(Split::kTrain)) {
    const Frame& frame = scene.frames[size_t(f)];
    for (size_t p = 0; p < frame.image.data.size() / 3; ++p) {
      if (!frame.mask.data.empty() && frame.mask.data[p] == 0) continue;
      for (size_t c = 0; c < 3; ++c) sum[c] += frame.image.data[3 * p + c] / 255.0;
      ++pixels;
    }
  }
  std::array<float, 3> mean{0.5f, 0.5f, 0.5f};
  for (size_t c = 0; c < 3 && pixels > 0; ++c) mean[c] = float(sum[c] / pixels);
  return mean;
}

}  // namespace

EnvironmentLight first_environment(const Scene& scene, const TrainOptions& options) {
  if (scene.had_alpha)
    throw InputError(
        fmt::format("{}: has frames with alpha, whose background is known; pass --environment "
                    "false",
                    scene.path));
  EnvironmentLight environment;
  environment.height = int(options.environment_size);
  const int64_t scalars = environment_scalars(environment.height);
  for (Buffer<float>* values :
       {&environment.map.value, &environment.map.moment1, &environment.map.moment2}) {
    values->resize(scalars);
    std::fill(values->begin(), values->end(), 0.0f);
  }
  const std::array<float, 3> mean = mean_colour(scene);
  for (int64_t i = 0; i < scalars; ++i) environment.map.value[i] = mean[size_t(i % 3)];
  return environment;
}

}  // namespace tessera
