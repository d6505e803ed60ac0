// The largest blending weight T·α of each Gaussian over the pixels of a batch. The traversal of
// tiles and splats is that of splat_sums.h, with the maximum in place of the sum.
#include "kernels/base/errors.h"
#include "kernels/cpu_backend.h"
#include "kernels/stages/splat_sums.h"

namespace tessera {
namespace {

/// A maximum under the name of a sum, so that sum_over_splats can form it.
template <class Real>
struct LargestWeight {
  Real weight;

  LargestWeight& operator+=(const LargestWeight& o) {
    weight = max_of(weight, o.weight);
    return *this;
  }
};

template <class Real>
struct WeightWalk : WalkState<Real> {
  using Sum = LargestWeight<Real>;
  static constexpr int kTerms = 1;

  void load(const BlendBackwardArgs<Real>& args, const Tile<Real>& tile) {
    load_pixels(args, tile, *this, [](int, int, int64_t) {});
  }

  template <bool ByFalloff>
  void row(const TileSplat<Real>& splat, Cutoff<Real> cutoff, int y, int32_t index,
           Real (&largest)[kTerms][kTileSize]) {
    const Real dy = splat.dy0 - Real(y);
    Real* T = this->transmittance[y];
    const int32_t* until = this->used[y];
    for (int x = 0; x < kTileSize; ++x) {
      const Real G = splat_falloff(splat.conic, splat.dx0 - Real(x), dy);
      const Real alpha = splat.opacity * G;
      const bool on = cutoff.template draws<ByFalloff>(alpha, G) && index < until[x];
      const Real weight = on ? T[x] * alpha : Real(0);
      T[x] -= weight;
      largest[0][x] = max_of(largest[0][x], weight);
    }
  }

  static Sum reduced(const TileSplat<Real>&, const Real (&lanes)[kTerms][kTileSize]) {
    Sum largest{};
    for (int x = 0; x < kTileSize; ++x) largest += {lanes[0][x]};
    return largest;
  }
};

}  // namespace

template <class Real>
void CpuBackend<Real>::largest_weights(const BlendArgs<Real>& forward, const Images<Real>& images,
                                       Span<Real> elements) {
  const Splats<Real>& splats = *forward.splats;
  check(elements.size + 1 == splats.first_of.size(), "largest_weights: one value a Gaussian");
  const BlendBackwardArgs<Real> pass{forward, &images, {}};
  Buffer<LargestWeight<Real>> of_instances, of_splats(splats.count);
  sum_over_splats<WeightWalk<Real>>(pass, pass, of_instances,
                                    [&](int64_t s, const auto& sum) { of_splats[s] = sum; });
  constexpr int64_t kGrain = 4096;
  parallel_for(elements.size, kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t n = begin; n < end; ++n)
      for (int64_t s = splats.first_of[n]; s < splats.first_of[n + 1]; ++s)
        elements[n] = max_of(elements[n], of_splats[s].weight);
  });
}

template void CpuBackend<float>::largest_weights(const BlendArgs<float>&, const Images<float>&,
                                                 Span<float>);
template void CpuBackend<double>::largest_weights(const BlendArgs<double>&, const Images<double>&,
                                                  Span<double>);

}  // namespace tessera
