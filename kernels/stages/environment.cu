// What: the environment behind every picture, and the gradient by its texels, on the device.
// Not: equations (math/environment.h).
// Pixels add to a texel in fixed point: whatever their order, the sum has the same bits.
// Source: method D.8.
#include "kernels/math/environment.h"

#include "kernels/base/errors.h"
#include "kernels/cuda/cuda_backend.h"
#include "kernels/cuda/device_error.h"
#include "kernels/math/adam.h"

namespace tessera {
namespace {

constexpr int kThreads = 256;
/// Gradients of a mean over all pixels are of order 1 or less; the sum of a texel may reach 2^19.
constexpr float kFixedPoint = 17592186044416.0f;  // 2^44

struct Rays {
  const ViewArgs<float>* views;  // [B]
  Mat3<float> map_from_world;
  int height;
};

/// The pixel of this thread in view blockIdx.y; false outside of the picture.
struct Ray {
  int64_t plane, pixels, first;  // index in a plane, size of a plane, first pixel of the view
  EnvironmentTap<float> tap;

  __device__ bool load(const Rays& rays) {
    const ViewArgs<float>& view = rays.views[blockIdx.y];
    pixels = int64_t(view.width) * view.height, first = view.first_pixel;
    plane = int64_t(blockIdx.x) * kThreads + threadIdx.x;
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
                  unsigned long long* sums) {
  Ray ray;
  if (!ray.load(rays)) return;
  const float T = transmittance[ray.first + ray.plane];
  for (int c = 0; c < 3; ++c) {
    const float g = T * d_colour[3 * ray.first + c * ray.pixels + ray.plane];
    for (int k = 0; k < 4; ++k) {
      const long long fixed = __float2ll_rn(ray.tap.share[k] * g * kFixedPoint);
      if (fixed != 0)
        atomicAdd(sums + 3 * ray.tap.texel[k] + c, static_cast<unsigned long long>(fixed));
    }
  }
}

__global__ void __launch_bounds__(kThreads)
    to_floats(const unsigned long long* sums, Span<float> d_map) {
  const int64_t i = int64_t(blockIdx.x) * kThreads + threadIdx.x;
  if (i < d_map.size) d_map[i] = float(static_cast<long long>(sums[i])) / kFixedPoint;
}

__global__ void __launch_bounds__(kThreads)
    adam_all(Span<const float> gradient, AdamScalars<float> adam, float* value, float* m,
             float* v) {
  const int64_t i = int64_t(blockIdx.x) * kThreads + threadIdx.x;
  if (i < gradient.size) adam_step(adam, gradient[i], value[i], m[i], v[i]);
}

/// One thread a pixel of the largest view, one row of blocks a view.
dim3 grid_of_views(const ViewBatch<float>& batch) {
  int64_t most = 0;
  for (const ViewArgs<float>& view : batch.views)
    most = max_of(most, int64_t(view.width) * view.height);
  return dim3(grid_of(most, kThreads), unsigned(batch.views.size()));
}

}  // namespace

void CudaBackend::environment(const EnvironmentArgs<float>& args, Images<float>& images) {
  check(args.map.size == environment_scalars(args.height), "environment: size of the map");
  if (args.batch->pixels == 0) return;
  add_environment<<<grid_of_views(*args.batch), kThreads, 0, stream_>>>(
      Rays{views_of(*args.batch), args.map_from_world, args.height}, args.map.data,
      images.transmittance.data(), images.colour.data());
  check_launch("environment");
  clock_.add_bytes(kBlend, 28.0 * double(args.batch->pixels));
}

void CudaBackend::environment_backward(const EnvironmentArgs<float>& args,
                                       const Images<float>& images, Span<const float> d_colour,
                                       Span<float> d_map) {
  check(d_map.size == environment_scalars(args.height), "environment: size of the gradient");
  const size_t bytes = sizeof(unsigned long long) * size_t(d_map.size);
  scratch_.resize(int64_t(bytes));
  auto* const sums = reinterpret_cast<unsigned long long*>(scratch_.data());
  check_device(cudaMemsetAsync(sums, 0, bytes, stream_), "memset");
  if (args.batch->pixels > 0)
    add_gradients<<<grid_of_views(*args.batch), kThreads, 0, stream_>>>(
        Rays{views_of(*args.batch), args.map_from_world, args.height}, images.transmittance.data(),
        d_colour.data, sums);
  to_floats<<<grid_of(d_map.size, kThreads), kThreads, 0, stream_>>>(sums, d_map);
  check_launch("environment_backward");
  clock_.add_bytes(kBlendBackward, 16.0 * double(args.batch->pixels));
}

void CudaBackend::adam_values(Span<const float> gradient, const AdamScalars<float>& adam,
                              Span<float> value, Span<float> moment1, Span<float> moment2) {
  if (value.empty()) return;
  adam_all<<<grid_of(value.size, kThreads), kThreads, 0, stream_>>>(gradient, adam, value.data,
                                                                    moment1.data, moment2.data);
  check_launch("adam_values");
  clock_.add_bytes(kUpdate, 28.0 * double(value.size));
}

}  // namespace tessera
