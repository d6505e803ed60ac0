// Chooses the frames and loads their pixels.
#include "ingest/derived/thinned_scene.h"

#include <algorithm>
#include <iterator>

#include "ingest/checks/stations.h"
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

void reduce(const Thinning& thinning, Frame& frame) {
  const int side = std::max(frame.image.width, frame.image.height);
  const double scale = std::min(1.0, double(thinning.largest) / side);
  if (scale == 1) return;
  const int width = scaled_side(frame.image.width, scale);
  const int height = scaled_side(frame.image.height, scale);
  frame.camera = frame.camera.resized(width, height);
  frame.image = scale_image(frame.image, width, height);
}

}  // namespace

ThinnedScene thinned_scene(const std::filesystem::path& folder, const Thinning& thinning) {
  const SceneFiles files(folder, true);
  SceneOptions options;
  options.load_pixels = false;
  ThinnedScene thinned;
  thinned.all = files.load(options);
  for (const TransformsFrame& listed : read_transforms(folder).frames)
    thinned.images.push_back(listed.image);
  options.load_pixels = true;
  const std::vector<int> chosen = chosen_frames(thinned.all, thinning);
  thinned.sample = thinned.all;
  thinned.sample.frames.clear();
  const size_t chunk = 4 * size_t(thread_count());  // as many are in memory in their own size
  for (size_t start = 0; start < chosen.size(); start += chunk) {
    const auto from = chosen.begin() + std::ptrdiff_t(start);
    options.frames.emplace(from, from + std::ptrdiff_t(std::min(chunk, chosen.size() - start)));
    std::vector<Frame> frames = files.load(options).frames;
    parallel_for(int64_t(frames.size()), 1, [&](int64_t begin, int64_t end) {
      for (auto k = size_t(begin); k < size_t(end); ++k) reduce(thinning, frames[k]);
    });
    std::move(frames.begin(), frames.end(), std::back_inserter(thinned.sample.frames));
  }
  return thinned;
}

}  // namespace tessera
