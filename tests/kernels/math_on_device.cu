// What: compiles the equations, the tile loop and both gradient sinks for a CUDA device.
// Not: run: it shows that kernels/math keeps its promise to be one source for host and device.
#include "kernels/math/blending.h"
#include "kernels/math/random.h"
#include "kernels/math/splat.h"
#include "kernels/math/ssim.h"
#include "kernels/stages/gradient_sink.h"

namespace tessera {

template <int Dim, class Sink>
__global__ void math_on_device(GaussianSpans<const float> set, ViewArgs<float> view, Sink sink,
                               Span<float> out) {
  const int64_t n = int64_t(blockIdx.x) * blockDim.x + threadIdx.x;
  GaussianState<float> gaussian;
  ViewSplat<float> splat;
  if (n >= out.size || !load_gaussian<Dim>(set, n, gaussian)) return;
  const BoundsOptions bounds;
  if (!splat_in_view(view, gaussian, 0.2f, 100.0f, bounds, splat)) return;
  int tiles = 0;
  for_each_tile(bounds, splat.footprint(), splat.rect, view.tiles_x, [&](int) { ++tiles; });
  GeometryGradient<float> gradient;
  SpacetimeGradient<float> d_spacetime{};
  project_ewa_backward(view, splat.projection.in_cam, gaussian.spacetime.covariance,
                       splat.projection.conic, Vec2<float>(1.0f), Sym2<float>{1, 0, 1},
                       gradient.mean, d_spacetime.covariance);
  slice_backward(gaussian.spacetime, splat.slice, gradient.mean, 1.0f, d_spacetime);
  sink.template accept<Dim>(n, gradient);
  sink.accept_sh(n, 0, gradient.opacity_logit);
  out[n] = float(tiles) + splat_falloff(splat.projection.conic, 1.0f, 1.0f) +
           ssim_point<float>({0.5f, 0.5f, 0.3f, 0.3f, 0.3f}).value +
           normals(philox(1, RandomStream::kSplit, uint64_t(n)))[0];
}

#define TESSERA_INSTANTIATE(Dim, Sink)                                                            \
  template __global__ void math_on_device<Dim, Sink>(GaussianSpans<const float>, ViewArgs<float>, \
                                                     Sink, Span<float>);
TESSERA_INSTANTIATE(3, StoreGradient<float>)
TESSERA_INSTANTIATE(3, ApplyAdam<float>)
TESSERA_INSTANTIATE(4, StoreGradient<float>)
TESSERA_INSTANTIATE(4, ApplyAdam<float>)

}  // namespace tessera
