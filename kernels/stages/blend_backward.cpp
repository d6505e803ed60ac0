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
  static constexpr int kTerms = 9;    // mean2d 2, conic 3, opacity 1, colour 3
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
    const Real *g0 = d_colour[0][y], *g1 = d_colour[1][y], *g2 = d_colour[2][y];
    Real *T = this->transmittance[y], *R = remaining[y];
    const int32_t* until = this->used[y];
    for (int x = 0; x < kTileSize; ++x) {
      const Real dx = splat.dx0 - Real(x);
      const Real G = splat_falloff(conic, dx, dy);
      const Real alpha = splat.opacity * G;
      const bool on = cutoff.template draws<ByFalloff>(alpha, G) && index < until[x];
      const Real drawn = on ? alpha : Real(0);
      const Real weight = T[x] * drawn;
      const Real kappa =
          splat.colour[0] * g0[x] + splat.colour[1] * g1[x] + splat.colour[2] * g2[x];
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

  static Sum reduced(const Real (&t)[kTerms]) {
    return {Vec2<Real>(t[0], t[1]), {t[2], t[3], t[4]}, t[5], Vec3<Real>(t[6], t[7], t[8])};
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
