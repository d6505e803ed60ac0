// The environment behind every image, and the gradient by its texels, on the device. Pixels add to
// a texel in fixed point, so the sum has the same bits in any order; NaN and infinity, which fixed
// point cannot hold, are stored beside it. Source: method D.8.
#include "kernels/math/environment.h"

#include <math_constants.h>

#include "kernels/base/errors.h"
#include "kernels/cuda/cuda_backend.h"
#include "kernels/cuda/device_memory.h"
#include "kernels/cuda/launch.cuh"
#include "kernels/math/adam.h"

namespace tessera {
namespace {

constexpr int kThreads = 256;
/// Gradients of a mean over all pixels are of order 1 or less; the sum of a texel may reach 2^19.
constexpr float kFixedPoint = 17592186044416.0f;  // 2^44
constexpr float kMost = 9223372036854775808.0f;   // 2^63

struct Rays {
  const ViewArgs<float>* views;  // [B]
  Mat3<float> map_from_world;
  int height;
};

/// The pixel of this thread in view blockIdx.y; false outside of the image.
struct Ray {
  int64_t plane, pixels, first;  // index in a plane, size of a plane, first pixel of the view
  EnvironmentTap<float> tap;

  __device__ bool load(const Rays& rays) {
    const ViewArgs<float>& view = rays.views[blockIdx.y];
    pixels = int64_t(view.width) * view.height;
    first = view.first_pixel;
    plane = linear_index();
    if (plane >= pixels) return false;
    const Vec3<float> in_world =
        pixel_direction(view, int(plane % view.width), int(plane / view.width));
    tap = environment_tap(rays.map_from_world * in_world, rays.height);
    return true;
  }
};

__global__ void __launch_bounds__(kThreads)
    add_environment(Rays rays, const float* map, const float* transmittance, float* colour) {
  Ray ray;
  if (!ray.load(rays)) return;
  const float T = transmittance[ray.first + ray.plane];
  for (int c = 0; c < 3; ++c)
    colour[3 * ray.first + c * ray.pixels + ray.plane] += T * environment_value(ray.tap, map, c);
}

__global__ void __launch_bounds__(kThreads)
    add_gradients(Rays rays, const float* transmittance, const float* d_colour,
                  unsigned long long* sums, uint32_t* bad) {
  Ray ray;
  if (!ray.load(rays)) return;
  const float T = transmittance[ray.first + ray.plane];
  for (int c = 0; c < 3; ++c) {
    const float g = T * d_colour[3 * ray.first + c * ray.pixels + ray.plane];
    for (int k = 0; k < 4; ++k) {
      const float scaled = ray.tap.share[k] * g * kFixedPoint;
      const int64_t scalar = 3 * ray.tap.texel[k] + c;
      if (!(fabsf(scaled) < kMost)) {  // fixed point has no NaN
        bad[scalar] = 1;
        continue;
      }
      const long long fixed = __float2ll_rn(scaled);
      if (fixed != 0) atomicAdd(sums + scalar, static_cast<unsigned long long>(fixed));
    }
  }
}

__global__ void __launch_bounds__(kThreads)
    to_floats(const unsigned long long* sums, const uint32_t* bad, Span<float> d_map) {
  const int64_t i = linear_index();
  if (i >= d_map.size) return;
  d_map[i] = bad[i] != 0 ? CUDART_NAN_F : float(static_cast<long long>(sums[i])) / kFixedPoint;
}

__global__ void __launch_bounds__(kThreads)
    adam_all(Span<const float> gradient, AdamScalars<float> adam, float* value, float* m, float* v,
             StepCounters* counters) {
  const int64_t i = linear_index();
  if (i >= gradient.size) return;
  adam_step(adam, gradient[i], value[i], m[i], v[i]);
  if (!isfinite(gradient[i]))
    counters->bad_values = 1;  // all threads that write it write the same value
}

}  // namespace

void CudaBackend::environment(const EnvironmentArgs<float>& args, Images<float>& images) {
  check(args.map.size == environment_scalars(args.height), "environment: size of the map");
  if (args.batch->pixels == 0) return;
  add_environment<<<grid_of_views(*args.batch, kThreads), kThreads, 0, stream_>>>(
      Rays{views_of(*args.batch), args.map_from_world, args.height}, args.map.data,
      images.transmittance.data(), images.colour.data());
  check_launch("environment");
  clock_.add_bytes(kBlend, 28.0 * double(args.batch->pixels));
}

void CudaBackend::environment_backward(const EnvironmentArgs<float>& args,
                                       const Images<float>& images, Span<const float> d_colour,
                                       Span<float> d_map) {
  check(d_map.size == environment_scalars(args.height), "environment: size of the gradient");
  Scratch scratch(scratch_);
  scratch.plan<unsigned long long>(d_map.size);
  scratch.plan<uint32_t>(d_map.size);
  scratch.allocate();
  const Span<unsigned long long> sums = scratch.take<unsigned long long>(d_map.size);
  const Span<uint32_t> bad = scratch.take<uint32_t>(d_map.size);  // 1: not finite
  check_device(cudaMemsetAsync(sums.data, 0, sizeof(*sums.data) * size_t(sums.size), stream_),
               "memset");
  check_device(cudaMemsetAsync(bad.data, 0, sizeof(*bad.data) * size_t(bad.size), stream_),
               "memset");
  if (args.batch->pixels > 0)
    add_gradients<<<grid_of_views(*args.batch, kThreads), kThreads, 0, stream_>>>(
        Rays{views_of(*args.batch), args.map_from_world, args.height}, images.transmittance.data(),
        d_colour.data, sums.data, bad.data);
  launch_linear<kThreads>(stream_, "environment_backward: to_floats", to_floats, d_map.size,
                          sums.data, bad.data, d_map);
  clock_.add_bytes(kBlendBackward, 16.0 * double(args.batch->pixels));
}

void CudaBackend::adam_values(Span<const float> gradient, const AdamScalars<float>& adam,
                              Span<float> value, Span<float> moment1, Span<float> moment2) {
  if (value.empty()) return;
  launch_linear<kThreads>(stream_, "adam_values: adam_all", adam_all, value.size, gradient, adam,
                          value.data, moment1.data, moment2.data, counters_.data());
  report();  // once more: project_backward's came before
  clock_.add_bytes(kUpdate, 28.0 * double(value.size));
}

}  // namespace tessera
