// What: gradient of blending, front to back, from the scalar R = ⟨colour still to come, dL/dC⟩.
// Not: atomics: each instance writes its own sum, a second pass adds those of a splat in order, so
//      the result does not depend on the number of threads.
// Source: method A.11, C.3.
#include "kernels/cpu_backend.h"
#include "kernels/stages/tile_loop.h"

namespace tessera {
namespace {

constexpr int kTerms = 9;  // mean2d 2, conic 3, opacity 1, colour 3

template <class Real>
struct PixelState {
  Real d_colour[3][kTileSize][kTileSize] = {};  // g
  Real remaining[kTileSize][kTileSize] = {};    // R
  Real transmittance[kTileSize][kTileSize] = {};
  int32_t used[kTileSize][kTileSize] = {};
  int32_t last = 0;  // most of `used`
};

template <class Real>
using Lanes = Real[kTerms][kTileSize];

template <class Real>
void load_tile(const BlendBackwardArgs<Real>& args, const Tile<Real>& tile,
               PixelState<Real>& state) {
  const int64_t first = tile.view->first_pixel, pixels = tile.view_pixels();
  for (int y = 0; y < tile.height; ++y)
    for (int x = 0; x < tile.width; ++x) {
      const int64_t p = tile.row_start(y) + x;
      Real R = Real(0);
      for (int c = 0; c < 3; ++c) {
        const Real g = args.d_colour[3 * first + c * pixels + p];
        state.d_colour[c][y][x] = g;
        R += g * args.images->colour[3 * first + c * pixels + p];
      }
      state.remaining[y][x] = R;
      state.transmittance[y][x] = Real(1);
      state.used[y][x] = args.images->used[first + p];
      state.last = max_of(state.last, state.used[y][x]);
    }
}

template <bool ByFalloff, class Real>
void backward_row(const TileSplat<Real>& splat, Cutoff<Real> cutoff, int y, int32_t index,
                  PixelState<Real>& state, Lanes<Real>& sum) {
  const Real dy = splat.dy0 - Real(y);
  const Sym2<Real>& conic = splat.conic;
  const Real *g0 = state.d_colour[0][y], *g1 = state.d_colour[1][y], *g2 = state.d_colour[2][y];
  Real *T = state.transmittance[y], *R = state.remaining[y];
  const int32_t* used = state.used[y];
  for (int x = 0; x < kTileSize; ++x) {
    const Real dx = splat.dx0 - Real(x);
    const Real G = splat_falloff(conic, dx, dy);
    const Real alpha = splat.opacity * G;
    const bool on = cutoff.template draws<ByFalloff>(alpha, G) && index < used[x];
    const Real drawn = on ? alpha : Real(0);
    const Real weight = T[x] * drawn;
    const Real kappa = splat.colour[0] * g0[x] + splat.colour[1] * g1[x] + splat.colour[2] * g2[x];
    R[x] -= weight * kappa;
    const Real beyond = R[x] / max_of(Real(1) - drawn, kMinOneMinusAlpha<Real>);
    const Real d_alpha = on ? T[x] * kappa - beyond : Real(0);
    const Real h = -drawn * d_alpha;
    sum[0][x] += h * (conic.xx * dx + conic.xy * dy);
    sum[1][x] += h * (conic.xy * dx + conic.yy * dy);
    sum[2][x] += Real(0.5) * h * dx * dx;
    sum[3][x] += Real(0.5) * h * dx * dy;
    sum[4][x] += Real(0.5) * h * dy * dy;
    sum[5][x] += G * d_alpha;
    sum[6][x] += weight * g0[x];
    sum[7][x] += weight * g1[x];
    sum[8][x] += weight * g2[x];
    T[x] *= Real(1) - drawn;
  }
}

template <class Real>
SplatGradient<Real> reduce(const Lanes<Real>& lanes) {
  Real sum[kTerms];
  for (int k = 0; k < kTerms; ++k) {
    sum[k] = Real(0);
    for (int x = 0; x < kTileSize; ++x) sum[k] += lanes[k][x];
  }
  return {Vec2<Real>(sum[0], sum[1]),
          {sum[2], sum[3], sum[4]},
          sum[5],
          Vec3<Real>(sum[6], sum[7], sum[8])};
}

template <class Real>
void add(const SplatGradient<Real>& g, SplatGradient<Real>& sum) {
  sum.mean2d += g.mean2d;
  sum.conic.xx += g.conic.xx, sum.conic.xy += g.conic.xy, sum.conic.yy += g.conic.yy;
  sum.opacity += g.opacity;
  sum.colour += g.colour;
}

}  // namespace

template <class Real>
void CpuBackend<Real>::blend_backward(const BlendBackwardArgs<Real>& args,
                                      Span<SplatGradient<Real>> d_splats) {
  const TileInstances<Real>& instances = *args.forward.instances;
  const Splats<Real>& splats = *args.forward.splats;
  const Cutoff<Real> cutoff = make_cutoff<Real>(args.forward.options);
  instance_gradients_.resize(instances.count);
  for_each_tile_of(*args.forward.batch, instances, [&](const Tile<Real>& tile) {
    PixelState<Real> state;
    load_tile(args, tile, state);
    for (int64_t i = tile.begin; i < tile.end; ++i) {
      const int32_t index = int32_t(i - tile.begin);
      if (index >= state.last) {
        instance_gradients_[i] = {};
        continue;
      }
      prefetch_splat(splats, instances, tile, i);
      Lanes<Real> sum = {};
      const TileSplat<Real> splat(splats, instances.splat[i], tile);
      for (int y = splat.first_row; y < splat.last_row; ++y)
        cutoff.by_falloff() ? backward_row<true>(splat, cutoff, y, index, state, sum)
                            : backward_row<false>(splat, cutoff, y, index, state, sum);
      instance_gradients_[i] = reduce(sum);
    }
  });
  constexpr int64_t kGrain = 1024;  // splats per task
  const Buffer<SplatGradient<Real>>& gradients = instance_gradients_;
  parallel_for(splats.count, kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t s = begin; s < end; ++s) {
      SplatGradient<Real> sum{};
      const int64_t first = instances.first_of[s], last = first + splats.tiles[s];
      for (int64_t k = first; k < last; ++k) {
        prefetch<16>(gradients, instances.slot, k, instances.count);
        add(gradients[instances.slot[k]], sum);
      }
      d_splats[s] = sum;
    }
  });
}

template void CpuBackend<float>::blend_backward(const BlendBackwardArgs<float>&,
                                                Span<SplatGradient<float>>);
template void CpuBackend<double>::blend_backward(const BlendBackwardArgs<double>&,
                                                 Span<SplatGradient<double>>);

}  // namespace tessera
