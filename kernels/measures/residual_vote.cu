// Levels of missed pixels and votes of places on the device: a thread a pixel, a thread a place.
#include "kernels/base/errors.h"
#include "kernels/cuda/cuda_backend.h"
#include "kernels/cuda/launch.cuh"

namespace tessera {
namespace {

constexpr int kThreads = 256;

__global__ void __launch_bounds__(kThreads)
    write_levels(const ViewArgs<float>* views, DeviceTarget target, const float* residual,
                 uint8_t* missed) {
  const ViewArgs<float>& view = views[blockIdx.y];
  const int64_t p = linear_index();
  if (p >= int64_t(view.width) * view.height) return;
  missed[view.first_pixel + p] =
      target.moves(blockIdx.y, p)
          ? missed_level(residual + 3 * view.first_pixel, view.width, view.height,
                         int(p % view.width), int(p / view.width))
          : uint8_t{0};
}

__global__ void __launch_bounds__(kThreads)
    write_votes(const ViewArgs<float>* views, int count, const uint8_t* missed,
                VoteGrid<float> grid, float* votes) {
  const int64_t place = linear_index();
  if (place < grid.places()) votes[place] = residual_vote(grid, place, views, count, missed);
}

}  // namespace

void CudaBackend::missed_pixels(const MissedArgs<float>& args, Span<uint8_t> missed) {
  check_missed(args, missed);
  if (missed.empty()) return;
  const DeviceTarget target = target_of({}, args.mask);
  write_levels<<<grid_of_views(*args.batch, kThreads), kThreads, 0, stream_>>>(
      views_of(*args.batch), target, args.residual.data, missed.data);
  check_launch("missed_pixels");
}

void CudaBackend::residual_votes(const VoteArgs<float>& args, Span<float> votes) {
  check_votes(args, votes);
  launch_linear<kThreads>(stream_, "residual_votes", write_votes, votes.size, views_of(*args.batch),
                          int(args.batch->views.size()), args.missed.data, args.grid, votes.data);
}

}  // namespace tessera
