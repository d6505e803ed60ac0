// The stages of a step called one by one on any backend, with all data between them copied to the
// host, in the order of the pipeline. All bits of a stage's output are set before it, so that
// unwritten values are found.
#pragma once
#include <map>
#include <utility>

#include "tests/support/render.h"

namespace tessera::testing {

template <class Real>
struct StageRun {
  ViewBatch<Real> batch;
  int64_t splats = 0, instances = 0, invalid = 0;  // as the backend counted
  std::vector<Splat<Real>> splat;
  std::vector<Real> depth;
  std::vector<TileRect> rect;
  std::vector<int32_t> tiles;
  std::vector<int64_t> first_of;  // of Gaussians
  std::vector<int32_t> instance_splat, depth_order;
  std::vector<int64_t> tile_begin, slot, first_slot;  // empty slots: the backend did without
  std::vector<Real> colour, transmittance, d_colour;
  std::vector<int32_t> used;
  std::vector<ViewLoss> losses;
  std::vector<ColourMap<double>> d_maps;
  std::vector<SplatGradient<Real>> d_splats;

  /// Gaussian · views + view of each splat.
  std::vector<int64_t> keys() const {
    std::vector<int64_t> keys(splat.size());
    for (size_t n = 0; n + 1 < first_of.size(); ++n)
      for (int64_t s = first_of[n]; s < first_of[n + 1]; ++s)
        keys[size_t(s)] = int64_t(n * batch.views.size()) + splat[size_t(s)].view;
    return keys;
  }
  /// The key of the splat that each pixel blended last, −1: none.
  std::vector<int64_t> last_drawn() const {
    const std::vector<int64_t> key = keys();
    std::vector<int64_t> last(used.size(), -1);
    for (const ViewArgs<Real>& v : batch.views)
      for (int64_t p = 0; p < int64_t(v.width) * v.height; ++p) {
        const int64_t place = used[size_t(v.first_pixel + p)] - 1;
        const int64_t tile =
            v.first_tile + p / v.width / kTileSize * v.tiles_x + p % v.width / kTileSize;
        if (place >= 0)
          last[size_t(v.first_pixel + p)] =
              key[size_t(instance_splat[size_t(tile_begin[size_t(tile)] + place)])];
      }
    return last;
  }
};

/// Gradients of splats from what blend_backward summed.
template <class Real>
std::vector<SplatGradient<Real>> gradients_of(const std::vector<Splat<Real>>& splats,
                                              const std::vector<SplatMoments<Real>>& moments) {
  std::vector<SplatGradient<Real>> out;
  for (size_t s = 0; s < moments.size(); ++s)
    out.push_back(splat_gradient(splats[s].conic, splats[s].opacity, moments[s]));
  return out;
}

/// Every bit of a buffer set: NaN, −1, a number of no splat.
template <class T>
void poison(Buffer<T>& buffer, Memory& memory) {
  const std::vector<unsigned char> ones(sizeof(T) * size_t(buffer.size()), 0xff);
  if (!ones.empty()) memory.copy(buffer.data(), ones.data(), ones.size());
}

/// What the loss compares: `colour` [3·pixels], or its colours mapped, where the target has maps,
/// in `mapped`.
template <class Real>
Span<const Real> compared_images(BackendOf<Real>& backend, const ViewBatch<Real>& batch,
                                 const Target& target, Span<const Real> colour,
                                 Buffer<Real>& mapped) {
  if (target.maps.empty()) return colour;
  mapped.resize(colour.size);
  poison(mapped, backend.memory());
  backend.map_colours({&batch, target.maps, colour}, mapped.span());
  return std::as_const(mapped).span();
}

template <class Real>
void poison_all(TileInstances<Real>& instances, Memory& memory) {
  poison(instances.splat, memory);
  poison(instances.tile_begin, memory);
  poison(instances.first_of, memory);
  poison(instances.slot, memory);
  poison(instances.depth_order, memory);
}

template <class Real>
void fetch_lists(const Splats<Real>& splats, const TileInstances<Real>& instances, Memory& memory,
                 StageRun<Real>& out) {
  out.splats = splats.count;
  out.invalid = splats.invalid;
  out.instances = instances.count;
  EXPECT_EQ(splats.instances, instances.count);
  out.splat = fetched(splats.splat, memory);
  out.depth = fetched(splats.depth, memory);
  out.rect = fetched(splats.rect, memory);
  out.tiles = fetched(splats.tiles, memory);
  out.first_of = fetched(splats.first_of, memory);
  out.instance_splat = fetched(instances.splat, memory);
  out.tile_begin = fetched(instances.tile_begin, memory);
  out.slot = fetched(instances.slot, memory);
  out.first_slot = fetched(instances.first_of, memory);
  out.depth_order = fetched(instances.depth_order, memory);
}

/// Whether blending may read these lists: its result with a poisoned one is undefined.
template <class Real>
bool lists_are_sound(const StageRun<Real>& run) {
  const auto all_in = [](const auto& values, int64_t low, int64_t high) {
    return std::all_of(values.begin(), values.end(),
                       [&](auto value) { return value >= low && value <= high; });
  };
  return all_in(run.instance_splat, 0, run.splats - 1) &&
         all_in(run.tile_begin, 0, run.instances) && all_in(run.slot, 0, run.instances - 1) &&
         std::is_sorted(run.tile_begin.begin(), run.tile_begin.end());
}

/// All stages up to the gradient of the splats. `edit` may replace dL/d image.
template <class Real>
StageRun<Real> run_stages(const TestScene<Real>& scene, BackendOf<Real>& backend,
                          const EditImageGradient<Real>& edit = {}) {
  Memory& memory = backend.memory();
  const StoredScene<Real> in(scene, memory);
  StageRun<Real> out;
  out.batch = make_view_batch<Real>(scene.views);
  const ViewBatch<Real>& batch = out.batch;
  Splats<Real> splats(memory);
  TileInstances<Real> instances(memory);
  Images<Real> images(memory);
  Buffer<Real> d_colour(3 * batch.pixels, memory);
  backend.project({&batch, {in.sets[0].view(), in.sets[1].view()}, scene.options, true}, splats);
  const BinArgs<Real> bin{&batch, &splats, scene.options, true};
  backend.bin(bin, instances);
  poison_all(instances, memory);
  backend.bin(bin, instances);
  fetch_lists(splats, instances, memory, out);
  if (!lists_are_sound(out)) {
    ADD_FAILURE() << "bin left a place unwritten";
    out.d_splats.resize(out.splat.size());
    return out;
  }
  const BlendArgs<Real> blend{&batch, &splats, &instances, scene.options, true};
  backend.blend(blend, images);
  poison(images.colour, memory);
  poison(images.transmittance, memory);
  poison(images.used, memory);
  poison(d_colour, memory);
  backend.blend(blend, images);
  const Target target = in.target();
  const Span<const Real> colour = std::as_const(images.colour).span();
  Buffer<Real> mapped(memory);
  backend.photometric({&batch, compared_images(backend, batch, target, colour, mapped),
                       target.truth, target.weights, target.mask},
                      d_colour.span());
  if (!target.maps.empty())
    backend.map_colours_backward({&batch, target.maps, colour}, d_colour.span());
  const StepOutcome outcome = backend.outcome();
  out.losses = outcome.losses;
  out.d_maps = outcome.d_maps;
  out.d_colour = fetched(d_colour, memory);
  if (edit) {
    edit(out.d_colour);
    store_over(out.d_colour, d_colour.span(), memory);
  }
  Buffer<SplatMoments<Real>> d_splats(splats.count, memory);
  poison(d_splats, memory);
  backend.blend_backward({blend, &images, d_colour.span()}, d_splats.span());
  out.colour = fetched(images.colour, memory);
  out.used = fetched(images.used, memory);
  out.transmittance = fetched(images.transmittance, memory);
  out.d_splats = gradients_of(out.splat, fetched(d_splats, memory));
  return out;
}

}  // namespace tessera::testing
