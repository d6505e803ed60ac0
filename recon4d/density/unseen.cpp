// Largest blending weights from batches of views through the forward pass, and the removal of
// Gaussians below the threshold.
#include "recon4d/density/unseen.h"

#include <algorithm>
#include <map>
#include <string>

#include "kernels/base/errors.h"
#include "recon4d/model/element_edits.h"

namespace tessera {

SampledViews views_of_training(const Scene& scene, int64_t enough, int64_t turn) {
  std::map<int64_t, std::vector<const Frame*>> timesteps;
  std::map<std::string, int64_t> cameras;  // with their place in the order of names
  int64_t count = 0;
  for (const int i : scene.split_indices(Split::kTrain)) {
    const Frame& frame = scene.frames[size_t(i)];
    check(frame.timestep >= 0, "views_of_training: timesteps have no numbers");
    timesteps[frame.timestep].push_back(&frame);
    cameras[frame.camera_name] = 0;
    ++count;
  }
  int64_t place = 0;
  for (auto& [name, camera] : cameras) camera = place++;
  const int64_t apart = std::max<int64_t>(1, count / enough);
  SampledViews sampled{{}, apart == 1};
  int64_t timestep = turn;
  for (const auto& [number, frames] : timesteps) {
    for (const Frame* frame : frames)
      if ((timestep + cameras.at(frame->camera_name)) % apart == 0)
        sampled.views.push_back({frame->camera, frame->time});
    ++timestep;
  }
  return sampled;
}

Buffer<float> largest_weights(Backend& backend, Pipeline<float>& pipeline,
                              ForwardArgs<float> forward, const SampledViews& sampled,
                              int64_t batch) {
  Buffer<float> none(forward.sets[0].count + forward.sets[1].count);
  std::fill_n(none.data(), none.size(), sampled.all ? 0.0f : -1.0f);
  Buffer<float> largest(backend.memory());
  largest.copy_from(none);
  forward.for_backward = true;
  const std::vector<View>& views = sampled.views;
  for (size_t first = 0; first < views.size(); first += size_t(batch)) {
    const size_t last = std::min(views.size(), first + size_t(batch));
    forward.views.assign(views.begin() + ptrdiff_t(first), views.begin() + ptrdiff_t(last));
    pipeline.forward(forward);
    pipeline.add_largest_weights(largest.span());
  }
  return largest;
}

std::array<DensityReport, 2> prune_where_not(Backend& backend, TrainState& state,
                                             const std::function<bool(int, int64_t)>& keeps) {
  const StageTimer timer(backend.clock(), kDensity);
  std::array<DensityReport, 2> reports;
  for (int k = 0; k < 2; ++k) {
    GaussianSet& set = state.set(k);
    DensityReport& report = reports[size_t(k)];
    report.before = report.after = set.count();
    if (!state.trains(k)) continue;
    std::vector<int64_t> kept;
    for (int64_t n = 0; n < report.before; ++n)
      if (keeps(k, n)) kept.push_back(n);
    report.after = int64_t(kept.size());
    report.pruned = report.before - report.after;
    if (report.pruned > 0) keep_elements(backend, kept, set, state.statistics[k]);
  }
  return reports;
}

std::array<DensityReport, 2> prune_unseen(Backend& backend, const Buffer<float>& largest,
                                          double least, TrainState& state) {
  check(largest.size() == state.model.count(), "prune_unseen: one weight a Gaussian");
  Buffer<float> weights;  // on the host
  weights.copy_from(largest);
  const int64_t fixed = state.set(0).count();
  return prune_where_not(backend, state, [&](int k, int64_t n) {
    const float weight = weights[k == 0 ? n : fixed + n];
    return weight < 0 || double(weight) >= least;
  });
}

}  // namespace tessera
