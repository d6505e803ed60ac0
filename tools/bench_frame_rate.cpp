// What: the pipeline's forward pass in a loop between two waits for the device.
// Not: the clock of the stages.
#include "tools/bench_frame_rate.h"

#include <chrono>

#include "kernels/base/errors.h"
#include "kernels/pipeline.h"
#include "recon4d/render.h"

namespace tessera {

FrameRate measure_frame_rate(Backend& backend, const GaussianModel& model,
                             const std::vector<View>& views, int64_t frames, double seconds) {
  check(!views.empty() && frames > 0, "measure_frame_rate: a view and a frame");
  using Clock = std::chrono::steady_clock;
  const RenderOptions options = render_options(model);
  const GaussianSet still = model.static_set.clone_values(backend.memory());
  const GaussianSet moving = model.dynamic_set.clone_values(backend.memory());
  Pipeline<float> pipeline(backend);
  // draws up to `count` frames and waits for the last
  const auto draw = [&](int64_t count, double limit) {
    const Clock::time_point begin = Clock::now();
    const auto elapsed = [&] {
      return std::chrono::duration<double>(Clock::now() - begin).count();
    };
    int64_t done = 0;
    do {
      pipeline.forward(still.values(), moving.values(), {views[size_t(done) % views.size()]},
                       options);
      ++done;
    } while (done < count && elapsed() < limit);
    backend.clock().totals();
    return FrameRate{double(done) / elapsed(), done};
  };
  draw(1 + frames / 10, 0.3 * seconds);
  return draw(frames, seconds);
}

}  // namespace tessera
