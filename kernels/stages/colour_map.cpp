// Colour maps applied to images on the CPU, and the gradients by the rendered images and by the
// maps. Source: kernels/math/colour_map.h.
#include "kernels/base/parallel.h"
#include "kernels/cpu_backend.h"

namespace tessera {
namespace {

constexpr int64_t kChunk = 1 << 13;  // pixels of a task

}  // namespace

template <class Real>
void CpuBackend<Real>::map_colours(const ColourMapArgs<Real>& args, Span<Real> mapped) {
  check_target(args);
  for (size_t b = 0; b < args.maps.size(); ++b) {
    const ViewArgs<Real>& view = args.batch->views[b];
    const int64_t pixels = int64_t(view.width) * view.height, first = 3 * view.first_pixel;
    const ColourMap<Real> map = args.maps[b].template as<Real>();
    parallel_for(pixels, kChunk, [&](int64_t begin, int64_t end) {
      for (int64_t p = begin; p < end; ++p)
        set_planar_colour(mapped.data + first, pixels, p,
                          map(planar_colour(args.colour.data + first, pixels, p)));
    });
  }
}

template <class Real>
void CpuBackend<Real>::map_colours_backward(const ColourMapArgs<Real>& args, Span<Real> d_colour) {
  check_target(args);
  outcome_.d_maps.assign(args.maps.size(), {Mat3<double>(0), Vec3<double>(0)});
  for (size_t b = 0; b < args.maps.size(); ++b) {
    const ViewArgs<Real>& view = args.batch->views[b];
    const int64_t pixels = int64_t(view.width) * view.height, first = 3 * view.first_pixel;
    const ColourMap<Real> map = args.maps[b].template as<Real>();
    std::vector<ColourMap<double>> sums(size_t((pixels + kChunk - 1) / kChunk),
                                        {Mat3<double>(0), Vec3<double>(0)});
    parallel_for(pixels, kChunk, [&](int64_t begin, int64_t end) {
      for (int64_t p = begin; p < end; ++p) {
        const Vec3<Real> d_x = planar_colour<Real>(d_colour.data + first, pixels, p);
        sums[size_t(begin / kChunk)] +=
            colour_map_gradient(planar_colour(args.colour.data + first, pixels, p), d_x)
                .template as<double>();
        set_planar_colour(d_colour.data + first, pixels, p, through_colour_map(map, d_x));
      }
    });
    for (const ColourMap<double>& sum : sums) outcome_.d_maps[b] += sum;
  }
}

template void CpuBackend<float>::map_colours(const ColourMapArgs<float>&, Span<float>);
template void CpuBackend<double>::map_colours(const ColourMapArgs<double>&, Span<double>);
template void CpuBackend<float>::map_colours_backward(const ColourMapArgs<float>&, Span<float>);
template void CpuBackend<double>::map_colours_backward(const ColourMapArgs<double>&, Span<double>);

}  // namespace tessera
