// The largest blending weight T·α of each Gaussian over the pixels of a batch, on the device. The
// traversal of tiles and splats is that of splat_sums.cuh, with the maximum in place of the sum.
// The order of maxima does not matter, so the result is the same in every run.
#include "kernels/base/errors.h"
#include "kernels/cuda/cuda_backend.h"
#include "kernels/cuda/launch.cuh"
#include "kernels/cuda/splat_sums.cuh"

namespace tessera {
namespace {

struct WeightPass : BlendBackward {  // sums: [N], of which d_colour is not read
  const int32_t* gaussian;           // [S]
};

/// A pixel on its way past the splats.
struct PixelWeight {
  using Args = WeightPass;
  static constexpr int kLaneTerms = 1, kTerms = 1;
  float x = 0, y = 0;  // centre
  float T = 1;
  int32_t used = 0;

  __device__ PixelWeight() {}
  __device__ PixelWeight(const WeightPass& a, const TilePixel& tile_pixel, const float4& before)
      : x(float(tile_pixel.x) + 0.5f), y(float(tile_pixel.y) + 0.5f), T(before.w) {
    if (tile_pixel.inside) used = a.used[tile_pixel.index];
  }

  template <class Add>
  __device__ void step(const SharedSplat& s, const PixelResponse& p, bool on, Add&& add) {
    const float weight = on ? T * (s.opacity() * p.falloff) : 0.0f;
    T -= weight;
    add(0, weight);
  }
  __device__ static float combine(float a, float b) { return fmaxf(a, b); }
  __device__ static float reduce(float, const float (&v)[kLaneTerms]) {
    // weights are not negative: their bits are in the order of their values
    return __int_as_float(largest_of_warp(__float_as_int(v[0])));
  }
  __device__ static int term_of_lane() { return int(threadIdx.x) % 32 == 0 ? 0 : kTerms; }
  __device__ static void give(const WeightPass& a, float* largest, int32_t splat, float weight) {
    float* const of_gaussian = largest + a.gaussian[splat];
    if (weight > *of_gaussian)  // rarely: most of its pixels show less of a Gaussian
      atomicMax(reinterpret_cast<int*>(of_gaussian), __float_as_int(weight));
  }
};

__global__ void raise_to_zero(const int32_t* gaussian, int64_t splats, float* largest) {
  const int64_t s = linear_index();
  if (s < splats && largest[gaussian[s]] < 0) largest[gaussian[s]] = 0;
}

}  // namespace

void CudaBackend::largest_weights(const BlendArgs<float>& forward, const Images<float>& images,
                                  Span<float> elements) {
  check(elements.size + 1 == forward.splats->first_of.size(),
        "largest_weights: one value a Gaussian");
  WeightPass a;
  static_cast<BlendBackward&>(a) = pass_of({forward, &images, {}}, elements.data);
  a.gaussian = forward.splats->gaussian.data();
  // a splat that draws no pixel is not visited below
  launch_linear<128>(stream_, "largest_weights", raise_to_zero, forward.splats->count, a.gaussian,
                     forward.splats->count, elements.data);
  launch_sums<PixelWeight, 2, true, false, false>(a, a.tiles, stream_);
  check_launch("largest_weights");
}

}  // namespace tessera
