// `parallel_for` on oneTBB. Builds without oneTBB link parallel_std.cpp instead.
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <memory>

#include "kernels/base/parallel.h"

namespace tessera {
namespace {

/// Never destroyed: at exit oneTBB may be gone before it.
std::unique_ptr<tbb::global_control>& limit() {
  static auto* const kept = new std::unique_ptr<tbb::global_control>;
  return *kept;
}

}  // namespace

void parallel_for(int64_t count, int64_t grain, const std::function<void(int64_t, int64_t)>& body) {
  if (count <= 0) return;
  const int64_t chunks = (count + grain - 1) / grain;
  if (chunks == 1) return body(0, count);
  if (SerialSection::is_here()) {
    for (int64_t c = 0; c < chunks; ++c) body(c * grain, std::min(count, (c + 1) * grain));
    return;
  }
  tbb::parallel_for(int64_t{0}, chunks, [&](int64_t chunk) {
    body(chunk * grain, std::min(count, (chunk + 1) * grain));
  });
}

void set_thread_count(int count) {
  limit().reset();
  if (count > 0)
    limit() = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                    size_t(count));
}

int thread_count() {
  return int(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

}  // namespace tessera
