// Levels of missed pixels and votes of places on the CPU.
#include "kernels/base/parallel.h"
#include "kernels/cpu_backend.h"

namespace tessera {

template <class Real>
void CpuBackend<Real>::missed_pixels(const MissedArgs<Real>& args, Span<uint8_t> missed) {
  check_missed(args, missed);
  for (size_t b = 0; b < args.batch->views.size(); ++b) {
    const ViewArgs<Real>& view = args.batch->views[b];
    const uint8_t* const mask = args.mask.empty() ? nullptr : args.mask[b].data;
    const Real* const residual = args.residual.data + 3 * view.first_pixel;
    uint8_t* const levels = missed.data + view.first_pixel;
    parallel_for(view.height, 16, [&](int64_t begin, int64_t end) {
      for (int64_t p = begin * view.width; p < end * view.width; ++p)
        levels[p] = mask != nullptr && mask[p] != kMovingPixel
                        ? uint8_t{0}
                        : missed_level(residual, view.width, view.height, int(p % view.width),
                                       int(p / view.width));
    });
  }
}

template <class Real>
void CpuBackend<Real>::residual_votes(const VoteArgs<Real>& args, Span<Real> votes) {
  check_votes(args, votes);
  const std::vector<ViewArgs<Real>>& views = args.batch->views;
  parallel_for(votes.size, 1024, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i)
      votes[i] = residual_vote(args.grid, i, views.data(), int(views.size()), args.missed.data);
  });
}

template void CpuBackend<float>::missed_pixels(const MissedArgs<float>&, Span<uint8_t>);
template void CpuBackend<double>::missed_pixels(const MissedArgs<double>&, Span<uint8_t>);
template void CpuBackend<float>::residual_votes(const VoteArgs<float>&, Span<float>);
template void CpuBackend<double>::residual_votes(const VoteArgs<double>&, Span<double>);

}  // namespace tessera
