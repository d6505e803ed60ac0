// The frames of a timestep are drawn and searched for missed pixels, places are voted on, and those
// that are missed most become Gaussians.
#include "recon4d/reduction/spawn_missed.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "kernels/math/random.h"
#include "recon4d/evaluation/scoring_pass.h"
#include "recon4d/model/new_gaussian.h"

namespace tessera {
namespace {

constexpr int64_t kMostSpawned = 6000;  // over all timesteps
constexpr int64_t kCandidates = 3;      // for each of them
constexpr double kOpacity = 0.4;
constexpr double kExtent = 0.7;  // temporal standard deviation, frames

/// The frames [places in the sample] of each timestep, by its number, that have moving pixels.
std::map<int64_t, std::vector<int64_t>> frames_by_timestep(const FrameSample& sample) {
  std::map<int64_t, std::vector<int64_t>> timesteps;
  for (int64_t i = 0; i < int64_t(sample.moving.size()); ++i)
    if (!sample.moving[size_t(i)].empty()) timesteps[sample.frame(i).timestep].push_back(i);
  std::erase_if(timesteps, [](const auto& t) { return t.second.size() < size_t(kMissingCameras); });
  return timesteps;
}

/// Around the dynamic Gaussians but for the outermost, a little larger; of 96 cubes along its
/// longest side.
VoteGrid<float> grid_around(const GaussianSet& dynamic_set) {
  constexpr double kTail = 0.02, kWider = 0.1, kCubes = 96;
  const GaussianSet set = dynamic_set.clone_values(host_memory());
  VoteGrid<float> grid;
  Vec3<float> low, high;
  std::vector<float> along(static_cast<size_t>(set.count()));
  for (int k = 0; k < 3; ++k) {
    for (int64_t n = 0; n < set.count(); ++n) along[size_t(n)] = set.values().at(kMean, n)[k];
    const auto tail = int64_t(kTail * double(set.count() - 1));
    std::nth_element(along.begin(), along.begin() + tail, along.end());
    low[k] = along[size_t(tail)];
    std::nth_element(along.begin(), along.end() - 1 - tail, along.end());
    high[k] = along[along.size() - 1 - size_t(tail)];
    const float wider = 0.5f * float(kWider) * (high[k] - low[k]);
    low[k] -= wider;
    high[k] += wider;
    grid.side = std::max(grid.side, (high[k] - low[k]) / float(kCubes));
  }
  if (!(grid.side > 0)) return {};
  for (int k = 0; k < 3; ++k) {
    grid.size[k] = std::max(1, int(std::ceil((high[k] - low[k]) / grid.side)));
    grid.first[k] = 0.5f * (low[k] + high[k] - float(grid.size[k] - 1) * grid.side);
  }
  return grid;
}

/// What the cameras of a timestep miss.
struct Missed {
  ViewBatch<float> batch;
  std::vector<uint8_t> levels;                   // [pixels]
  std::vector<std::pair<float, int64_t>> votes;  // −vote and its place, of those with one
};

/// `batch`: frames drawn at once.
Missed look_at_timestep(Backend& backend, ScoringPass& pass, const FrameSample& sample,
                        const std::vector<int64_t>& frames, size_t batch,
                        const VoteGrid<float>& grid) {
  std::vector<View> views;
  for (const int64_t i : frames) views.push_back(sample.view(i));
  Missed missed{make_view_batch<float>(views), {}, {}};
  Buffer<uint8_t> levels(missed.batch.pixels, backend.memory());
  for (size_t begin = 0; begin < frames.size(); begin += batch) {
    const size_t end = std::min(frames.size(), begin + batch);
    const int64_t first = missed.batch.views[begin].first_pixel;
    const int64_t last =
        end < frames.size() ? missed.batch.views[end].first_pixel : missed.batch.pixels;
    pass.draw(sample, {frames.begin() + ptrdiff_t(begin), frames.begin() + ptrdiff_t(end)});
    pass.missed_pixels({levels.data() + first, last - first});
  }
  Buffer<float> votes(grid.places(), backend.memory());
  backend.residual_votes({&missed.batch, std::as_const(levels).span(), grid}, votes.span());
  Buffer<float> on_host;
  on_host.copy_from(votes);
  for (int64_t place = 0; place < on_host.size(); ++place)
    if (on_host[place] > 0) missed.votes.emplace_back(-on_host[place], place);
  missed.levels.resize(size_t(levels.size()));
  backend.memory().copy(missed.levels.data(), levels.data(), missed.levels.size());
  return missed;
}

/// Mean of what the cameras that miss a point show there, as the scene has it.
Vec3<float> colour_at(const Missed& missed, const FrameSample& sample,
                      const std::vector<int64_t>& frames, const Vec3<float>& point, float near) {
  Vec3<double> sum{};
  int count = 0;
  for (size_t b = 0; b < frames.size(); ++b) {
    const ViewArgs<float>& view = missed.batch.views[b];
    const int64_t pixel = pixel_of(view, point, near);
    if (pixel < 0 || missed.levels[size_t(view.first_pixel + pixel)] == 0) continue;
    ColourMap<double> map;
    if (!sample.maps.empty()) map = sample.maps[size_t(frames[b])];
    const Vec3<double> gain = channel_response(map);
    for (int c = 0; c < 3; ++c)
      sum[c] +=
          (sample.frame(frames[b]).image.data[size_t(3 * pixel + c)] / 255.0 - map.offset[c]) /
          std::max(0.1, gain[c]);
    ++count;
  }
  Vec3<float> colour;
  for (int c = 0; c < 3; ++c) colour[c] = float(std::clamp(sum[c] / std::max(1, count), 0.0, 1.0));
  return colour;
}

}  // namespace

GaussianSet spawn_missed(Backend& backend, const GaussianModel& model, const FrameSample& sample,
                         uint64_t seed) {
  GaussianSet spawned = model.dynamic_set.like();
  const std::map<int64_t, std::vector<int64_t>> timesteps = frames_by_timestep(sample);
  if (timesteps.size() < 2 || model.dynamic_set.count() == 0 || model.dynamic_set.dim() != 4)
    return spawned;
  const VoteGrid<float> grid = grid_around(model.dynamic_set);
  if (grid.places() == 0) return spawned;
  const auto time_of = [&](const auto& t) { return sample.frame(t.second.front()).time; };
  const double frame_time = (time_of(*timesteps.rbegin()) - time_of(*timesteps.begin())) /
                            double(timesteps.rbegin()->first - timesteps.begin()->first);
  const int64_t most = std::max<int64_t>(1, kMostSpawned / int64_t(timesteps.size()));
  ScoringPass pass(backend, model, false);
  const auto batch = size_t(sample.at_once());
  std::vector<NewGaussian> found;
  for (const auto& [timestep, frames] : timesteps) {
    Missed missed = look_at_timestep(backend, pass, sample, frames, batch, grid);
    std::sort(missed.votes.begin(), missed.votes.end());
    const int64_t candidates = std::min(int64_t(missed.votes.size()), kCandidates * most);
    const int64_t chosen = std::min(candidates, most);
    for (int64_t i = 0; i < chosen; ++i) {
      const int64_t place = missed.votes[size_t(i * candidates / chosen)].second;
      const RandomBlock random = philox(seed, RandomStream::kSpawn, uint64_t(found.size()), 0);
      NewGaussian gaussian;
      gaussian.colour = colour_at(missed, sample, frames, grid.centre(place), grid.side);
      gaussian.position = grid.centre(place);
      for (int k = 0; k < 3; ++k)
        gaussian.position[k] += grid.side * (uniform(random.word[k]) - 0.5f);
      gaussian.log_scale = std::log(0.5f * grid.side);
      gaussian.opacity = kOpacity;
      gaussian.mean_time = float(sample.frame(frames.front()).time);
      gaussian.time_scale = kExtent * frame_time;
      found.push_back(gaussian);
    }
  }
  spawned.resize(int64_t(found.size()));
  for (size_t n = 0; n < found.size(); ++n) write_gaussian(found[n], spawned, int64_t(n));
  return spawned;
}

}  // namespace tessera
