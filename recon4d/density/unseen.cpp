// Largest blending weights from batches of views through the forward pass, and the removal of
// Gaussians below the threshold.
#include "recon4d/density/unseen.h"

#include <algorithm>

#include "kernels/base/errors.h"
#include "recon4d/evaluation/frame_sample.h"
#include "recon4d/model/element_edits.h"

namespace tessera {

std::vector<View> views_of_training(const Scene& scene, int64_t enough) {
  const FrameSample sample = sample_training_frames(scene);
  std::vector<View> views;
  for (const std::vector<FrameRange>& sweep : sample.sweeps) {
    if (int64_t(views.size()) >= enough) break;
    for (const FrameRange& series : sweep)
      for (int64_t i = series.begin; i < series.end; ++i)
        views.push_back({sample.frame(i).camera, sample.frame(i).time});
  }
  return views;
}

Buffer<float> largest_weights(Backend& backend, Pipeline<float>& pipeline,
                              ForwardArgs<float> forward, const std::vector<View>& views,
                              int64_t batch) {
  Buffer<float> largest(forward.sets[0].count + forward.sets[1].count, backend.memory());
  backend.fill_zero(largest.span());
  forward.for_backward = true;
  for (size_t first = 0; first < views.size(); first += size_t(batch)) {
    const size_t last = std::min(views.size(), first + size_t(batch));
    forward.views.assign(views.begin() + ptrdiff_t(first), views.begin() + ptrdiff_t(last));
    pipeline.forward(forward);
    pipeline.add_largest_weights(largest.span());
  }
  return largest;
}

std::array<DensityReport, 2> prune_unseen(Backend& backend, const Buffer<float>& largest,
                                          double least, TrainState& state) {
  check(largest.size() == state.model.count(), "prune_unseen: one weight a Gaussian");
  Buffer<float> weights;  // on the host
  weights.copy_from(largest);
  const StageTimer timer(backend.clock(), kDensity);
  std::array<DensityReport, 2> reports;
  int64_t first = 0;
  for (int k = 0; k < 2; ++k) {
    GaussianSet& set = state.set(k);
    DensityReport& report = reports[size_t(k)];
    report.before = set.count();
    std::vector<int64_t> seen;
    for (int64_t n = 0; n < report.before; ++n)
      if (double(weights[first + n]) >= least) seen.push_back(n);
    first += report.before;
    report.after = int64_t(seen.size());
    report.pruned = report.before - report.after;
    if (report.pruned > 0) keep_elements(backend, seen, set, state.statistics[k]);
  }
  return reports;
}

}  // namespace tessera
