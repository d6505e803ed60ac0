// The environment behind every image, the gradient by its texels, and Adam over plain values, on
// the CPU. The rows of all images are cut into a fixed number of parts with one map each; the maps
// are added in order, so the result does not depend on the number of threads. Source: method D.8.
#include "kernels/math/environment.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"
#include "kernels/cpu_backend.h"

namespace tessera {
namespace {

constexpr int64_t kParts = 8;

/// Calls body(view, first index of the plane, pixel, tap) for the pixels of rows [begin, end) of
/// all views, numbered through.
template <class Real, class Body>
void for_each_ray(const EnvironmentArgs<Real>& args, int64_t begin, int64_t end, Body&& body) {
  int64_t first = 0;
  for (const ViewArgs<Real>& view : args.batch->views) {
    const int64_t from = std::clamp<int64_t>(begin - first, 0, view.height);
    const int64_t to = std::clamp<int64_t>(end - first, 0, view.height);
    for (int y = int(from); y < int(to); ++y)
      for (int x = 0; x < view.width; ++x) {
        const Vec3<Real> direction = args.map_from_world * pixel_direction(view, x, y);
        body(view, int64_t(y) * view.width + x, environment_tap(direction, args.height));
      }
    first += view.height;
  }
}

template <class Real>
int64_t rows_of(const ViewBatch<Real>& batch) {
  int64_t rows = 0;
  for (const ViewArgs<Real>& view : batch.views) rows += view.height;
  return rows;
}

}  // namespace

template <class Real>
void CpuBackend<Real>::environment(const EnvironmentArgs<Real>& args, Images<Real>& images) {
  check(args.map.size == environment_scalars(args.height), "environment: size of the map");
  constexpr int64_t kGrain = 8;  // rows per task
  parallel_for(rows_of(*args.batch), kGrain, [&](int64_t begin, int64_t end) {
    for_each_ray(args, begin, end, [&](const auto& view, int64_t p, const auto& tap) {
      const Real T = images.transmittance[view.first_pixel + p];
      for (int c = 0; c < 3; ++c)
        images.colour[3 * view.first_pixel + c * int64_t(view.width) * view.height + p] +=
            T * environment_value(tap, args.map.data, c);
    });
  });
}

template <class Real>
void CpuBackend<Real>::environment_backward(const EnvironmentArgs<Real>& args,
                                            const Images<Real>& images, Span<const Real> d_colour,
                                            Span<Real> d_map) {
  check(d_map.size == environment_scalars(args.height), "environment: size of the gradient");
  const int64_t rows = rows_of(*args.batch);
  environment_parts_.resize(kParts * d_map.size);
  std::fill(environment_parts_.begin(), environment_parts_.end(), Real(0));
  parallel_for(kParts, 1, [&](int64_t part, int64_t) {
    Real* const sum = environment_parts_.data() + part * d_map.size;
    for_each_ray(args, part * rows / kParts, (part + 1) * rows / kParts,
                 [&](const auto& view, int64_t p, const auto& tap) {
                   const int64_t pixels = int64_t(view.width) * view.height;
                   const Real T = images.transmittance[view.first_pixel + p];
                   for (int c = 0; c < 3; ++c) {
                     const Real g = T * d_colour[3 * view.first_pixel + c * pixels + p];
                     for (int k = 0; k < 4; ++k) sum[3 * tap.texel[k] + c] += tap.share[k] * g;
                   }
                 });
  });
  constexpr int64_t kGrain = 4096;  // scalars per task
  parallel_for(d_map.size, kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) {
      Real sum = Real(0);
      for (int64_t part = 0; part < kParts; ++part)
        sum += environment_parts_[part * d_map.size + i];
      d_map[i] = sum;
    }
  });
}

template <class Real>
void CpuBackend<Real>::adam_values(Span<const Real> gradient, const AdamScalars<Real>& adam,
                                   Span<Real> value, Span<Real> moment1, Span<Real> moment2) {
  constexpr int64_t kGrain = 4096;  // scalars per task
  std::atomic<bool> bad = false;
  parallel_for(value.size, kGrain, [&](int64_t begin, int64_t end) {
    bool finite = true;
    for (int64_t i = begin; i < end; ++i) {
      finite &= std::isfinite(gradient[i]);
      adam_step(adam, gradient[i], value[i], moment1[i], moment2[i]);
    }
    if (!finite) bad = true;
  });
  outcome_.bad_values |= bad;
}

#define TESSERA_INSTANTIATE(Real)                                                           \
  template void CpuBackend<Real>::environment(const EnvironmentArgs<Real>&, Images<Real>&); \
  template void CpuBackend<Real>::environment_backward(                                     \
      const EnvironmentArgs<Real>&, const Images<Real>&, Span<const Real>, Span<Real>);     \
  template void CpuBackend<Real>::adam_values(Span<const Real>, const AdamScalars<Real>&,   \
                                              Span<Real>, Span<Real>, Span<Real>);
TESSERA_INSTANTIATE(float)
TESSERA_INSTANTIATE(double)

}  // namespace tessera
