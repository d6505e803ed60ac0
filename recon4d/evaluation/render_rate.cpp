// What: forward passes between two readings of the backend's clock.
// Not: the clock (kernels/stage_clock.h).
#include "recon4d/evaluation/render_rate.h"

#include <chrono>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

double stage_seconds(Backend& backend) {
  double sum = 0;
  for (const StageTotals& stage : backend.clock().totals()) sum += stage.seconds;  // waits
  return sum;
}

}  // namespace

RenderRate measure_render_rate(Backend& backend, const GaussianModel& model,
                               const std::vector<View>& views, const RenderRateOptions& options) {
  using Clock = std::chrono::steady_clock;
  check(!views.empty() && options.frames > 0, "measure_render_rate: views and frames");
  Renderer renderer(backend, model);
  const auto draw = [&](int64_t i) { renderer.draw({views[size_t(i) % views.size()]}); };
  const auto since = [](Clock::time_point begin) {
    return std::chrono::duration<double>(Clock::now() - begin).count();
  };
  const Clock::time_point start = Clock::now();
  for (int64_t i = 0; i < options.warm_up && (i == 0 || since(start) < options.seconds / 4); ++i)
    draw(i);
  RenderRate rate;
  rate.width = views.front().camera.width;
  rate.height = views.front().camera.height;
  rate.num_gaussians = model.count();
  const double before = stage_seconds(backend);
  const Clock::time_point begin = Clock::now();
  while (rate.frames < options.frames && (rate.frames == 0 || since(begin) < options.seconds))
    draw(rate.frames++);
  rate.seconds = stage_seconds(backend) - before;
  rate.wall_seconds = since(begin);
  return rate;
}

}  // namespace tessera
