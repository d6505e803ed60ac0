// Gradient of blending on the CPU, front to back from the scalar R = ⟨colour still to come, dL/dC⟩.
// The traversal is in splat_sums.h. Source: method A.11, C.3.
#include "kernels/cpu_backend.h"
#include "kernels/stages/splat_sums.h"

namespace tessera {
namespace {

/// `Lengths`: with the sum over pixels of the lengths of their gradients by the splat's place.
template <class Real, bool Lengths>
struct GradientWalk : WalkState<Real> {
  using Sum = std::conditional_t<Lengths, MomentsAndLength<Real>, SplatMoments<Real>>;
  static constexpr int kTerms = kColumnTerms + int(Lengths);
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
    const Real* const g0 = d_colour[0][y];
    const Real* const g1 = d_colour[1][y];
    const Real* const g2 = d_colour[2][y];
    Real* const T = this->transmittance[y];
    Real* const R = remaining[y];
    const int32_t* until = this->used[y];
    for (int x = 0; x < kTileSize; ++x) {
      const Real G = splat_falloff(splat.conic, splat.dx0 - Real(x), dy);
      const bool lit = index < until[x];
      const bool on = cutoff.template draws<ByFalloff>(splat.opacity * G, G) && lit;
      blend_backward_step<Real>(splat.opacity, on ? G : Real(0), dy, splat.colour,
                                {g0[x], g1[x], g2[x]}, T[x], R[x], [&](int k, Real term) {
                                  sum[k][x] += term;
                                  if constexpr (Lengths)
                                    if (k == 0)
                                      sum[kColumnTerms][x] +=
                                          abs_of(term) *
                                          slope_length(splat.conic, splat.dx0 - Real(x), dy);
                                });
    }
  }

  static Sum reduced(const TileSplat<Real>& splat, const Real (&lanes)[kTerms][kTileSize]) {
    Sum sum{};
    SplatMoments<Real>& moments = sum;
    for (int x = 0; x < kTileSize; ++x) {
      if constexpr (Lengths) sum.length += lanes[kColumnTerms][x];
      Real column[kColumnTerms];
      for (int k = 0; k < kColumnTerms; ++k) column[k] = lanes[k][x];
      moments += column_moments(splat.dx0 - Real(x), column);
    }
    return sum;
  }
};

}  // namespace

template <class Real>
void CpuBackend<Real>::blend_backward(const BlendBackwardArgs<Real>& args,
                                      Span<SplatMoments<Real>> d_splats) {
  if (args.lengths.empty()) {
    instance_lengths_.release();
    sum_over_splats<GradientWalk<Real, false>>(
        args, args, instance_gradients_, [&](int64_t s, const auto& sum) { d_splats[s] = sum; });
  } else {
    instance_gradients_.release();
    sum_over_splats<GradientWalk<Real, true>>(args, args, instance_lengths_,
                                              [&](int64_t s, const auto& sum) {
                                                d_splats[s] = sum;
                                                args.lengths[s] = sum.length;
                                              });
  }
}

template void CpuBackend<float>::blend_backward(const BlendBackwardArgs<float>&,
                                                Span<SplatMoments<float>>);
template void CpuBackend<double>::blend_backward(const BlendBackwardArgs<double>&,
                                                 Span<SplatMoments<double>>);

}  // namespace tessera
