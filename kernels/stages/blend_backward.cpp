// What: gradient of blending, front to back, from the scalar R = ⟨colour still to come, dL/dC⟩.
// Not: the walk through tiles and splats (splat_sums.h).
// Source: method A.11, C.3.
#include "kernels/cpu_backend.h"
#include "kernels/stages/splat_sums.h"

namespace tessera {
namespace {

template <class Real>
struct GradientWalk : WalkState<Real> {
  using Sum = SplatGradient<Real>;
  static constexpr int kTerms = kSplatGradientTerms;
  TileValues<Real> d_colour[3] = {};  // g
  TileValues<Real> remaining = {};    // R

  void load(const BlendBackwardArgs<Real>& args, const Tile<Real>& tile) {
    const int64_t pixels = tile.view_pixels();
    load_pixels(args, tile, *this, [&](int x, int y, int64_t i) {
      Real R = Real(0);
      for (int c = 0; c < 3; ++c) {
        const Real g = args.d_colour[i + c * pixels];
        d_colour[c][y][x] = g;
        R += g * args.images->colour[i + c * pixels];
      }
      remaining[y][x] = R;
    });
  }

  template <bool ByFalloff>
  void row(const TileSplat<Real>& splat, Cutoff<Real> cutoff, int y, int32_t index,
           Real (&sum)[kTerms][kTileSize]) {
    const Real dy = splat.dy0 - Real(y);
    const Sym2<Real>& conic = splat.conic;
    const Real* const g0 = d_colour[0][y];
    const Real* const g1 = d_colour[1][y];
    const Real* const g2 = d_colour[2][y];
    Real* const T = this->transmittance[y];
    Real* const R = remaining[y];
    const int32_t* until = this->used[y];
    for (int x = 0; x < kTileSize; ++x) {
      const Real dx = splat.dx0 - Real(x);
      const Real G = splat_falloff(conic, dx, dy);
      const Real alpha = splat.opacity * G;
      const bool lit = index < until[x];
      const bool on = cutoff.template draws<ByFalloff>(alpha, G) && lit;
      const SplatAtPixel<Real> splat_at_pixel{
          dx, dy, conic.xx * dx + conic.xy * dy, conic.xy * dx + conic.yy * dy, G, alpha};
      blend_backward_step<Real>(splat_at_pixel, on, splat.colour, {g0[x], g1[x], g2[x]}, T[x], R[x],
                                [&](int k, Real term) { sum[k][x] += term; });
    }
  }

  static Sum reduced(const Real (&t)[kTerms]) {
    constexpr Real kHalf = Real(0.5);  // of blend_backward_step
    return {Vec2<Real>(t[0], t[1]),
            {kHalf * t[2], kHalf * t[3], kHalf * t[4]},
            t[5],
            Vec3<Real>(t[6], t[7], t[8])};
  }
};

}  // namespace

template <class Real>
void CpuBackend<Real>::blend_backward(const BlendBackwardArgs<Real>& args,
                                      Span<SplatGradient<Real>> d_splats) {
  sum_over_splats<GradientWalk<Real>>(args, args, instance_gradients_, d_splats);
}

template void CpuBackend<float>::blend_backward(const BlendBackwardArgs<float>&,
                                                Span<SplatGradient<float>>);
template void CpuBackend<double>::blend_backward(const BlendBackwardArgs<double>&,
                                                 Span<SplatGradient<double>>);

}  // namespace tessera
