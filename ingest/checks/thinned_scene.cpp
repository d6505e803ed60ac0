// Chooses the frames and loads their pixels.
#include "ingest/checks/thinned_scene.h"

#include <algorithm>

#include "ingest/checks/stations.h"
#include "ingest/files/png.h"
#include "ingest/images/alpha_and_mask.h"
#include "ingest/images/resampling.h"
#include "ingest/prepared/scene_reader.h"
#include "ingest/prepared/transforms_json.h"
#include "kernels/base/median.h"
#include "kernels/base/parallel.h"

namespace tessera {
namespace {

/// `most` of `count` places, the first and the last among them.
std::vector<size_t> spread(size_t count, int most) {
  std::vector<size_t> places;
  const size_t wanted = std::min(count, size_t(std::max(1, most)));
  for (size_t i = 0; i < wanted; ++i)
    places.push_back(size_t(even_spread(int64_t(i), int64_t(wanted), int64_t(count))));
  return places;
}

std::vector<int> chosen_frames(const Scene& scene, const Thinning& thinning) {
  const std::vector<Station> stations = stations_of(scene);
  std::vector<int> chosen;
  for (const size_t s : spread(stations.size(), thinning.stations))
    for (const size_t i : spread(stations[s].frames.size(), thinning.instants))
      chosen.push_back(stations[s].frames[i]);
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

void load_pixels(Frame& frame, const std::filesystem::path& file, const Thinning& thinning,
                 std::array<uint8_t, 3> background) {
  Image8 image = read_png(file);
  if (image.channels != 3) image = composite_on(image, background);
  const double scale =
      std::min(1.0, double(thinning.largest) / std::max(image.width, image.height));
  if (scale < 1) {
    const int width = scaled_side(image.width, scale);
    const int height = scaled_side(image.height, scale);
    frame.camera = frame.camera.resized(width, height);
    image = scale_image(image, width, height);
  }
  frame.image = std::move(image);
}

}  // namespace

ThinnedScene thinned_scene(const std::filesystem::path& folder, const Thinning& thinning) {
  SceneOptions options;
  options.allow_static = true;
  options.load_pixels = false;
  ThinnedScene thinned;
  thinned.all = load_scene(folder, options);
  for (const TransformsFrame& listed : read_transforms(folder).frames)
    thinned.images.push_back(listed.image);
  const std::vector<int> chosen = chosen_frames(thinned.all, thinning);
  thinned.sample = thinned.all;
  thinned.sample.frames.clear();
  for (const int i : chosen) thinned.sample.frames.push_back(thinned.all.frames[size_t(i)]);
  parallel_for(int64_t(chosen.size()), 1, [&](int64_t begin, int64_t end) {
    for (auto k = size_t(begin); k < size_t(end); ++k)
      load_pixels(thinned.sample.frames[k], thinned.images[size_t(chosen[k])], thinning,
                  thinned.all.background);
  });
  return thinned;
}

}  // namespace tessera
