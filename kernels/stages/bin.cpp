// What: splats → tile instances: depth order once, then a stable counting sort by tile.
// Not: the tile test (math/bounds.h), which project used for the counts that this stage trusts.
// Source: depth-then-tile sort of [Splatshop], [Faster-GS]; method A.9.
#include <type_traits>

#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"
#include "kernels/cpu_backend.h"
#include "kernels/stages/radix_order.h"

namespace tessera {
namespace {

/// Splats of a task; the histogram of each task costs one counter per tile.
constexpr int64_t kMinGrain = 16384;
constexpr int64_t kMaxTasks = 16;

template <class Real>
using KeyOf = std::conditional_t<sizeof(Real) == 4, uint32_t, uint64_t>;

template <class Real, class Visit>
void visit_tiles(const ViewBatch<Real>& batch, const Splats<Real>& splats, int64_t s,
                 Visit&& visit) {
  const ViewArgs<Real>& view = batch.views[size_t(splats.view[s])];
  const Footprint<Real> footprint{splats.mean2d[s], splats.conic[s],
                                  cutoff_power(splats.opacity[s])};
  for_each_tile(footprint, splats.rect[s], view.tiles_x,
                [&](int tile) { visit(view.first_tile + tile); });
}

}  // namespace

template <class Real>
void CpuBackend<Real>::bin(const ViewBatch<Real>& batch, const Splats<Real>& splats,
                           bool for_backward, TileInstances<Real>& out) {
  // z > 0, so the bits of a depth order as the depth does; equal depths keep the order of Gaussians
  radix_order(reinterpret_cast<const KeyOf<Real>*>(splats.depth.data()), splats.count,
              out.depth_order);
  out.first_of.resize(splats.count + 1);
  out.first_of[0] = 0;
  for (int64_t s = 0; s < splats.count; ++s)
    out.first_of[s + 1] = out.first_of[s] + splats.tiles[s];
  out.count = out.first_of[splats.count];
  out.splat.resize(out.count);
  out.slot.resize(for_backward ? out.count : 0);
  out.tile_begin.resize(batch.tiles + 1);

  const int64_t grain = max_of(kMinGrain, (splats.count + kMaxTasks - 1) / kMaxTasks);
  const int64_t tasks = (splats.count + grain - 1) / grain;
  std::vector<int64_t> cursor(static_cast<size_t>(tasks * batch.tiles), 0);
  parallel_for(splats.count, grain, [&](int64_t begin, int64_t end) {
    int64_t* histogram = cursor.data() + begin / grain * batch.tiles;
    for (int64_t k = begin; k < end; ++k)
      visit_tiles(batch, splats, out.depth_order[k], [&](int64_t tile) { ++histogram[tile]; });
  });
  int64_t total = 0;
  for (int64_t tile = 0; tile < batch.tiles; ++tile) {
    out.tile_begin[tile] = total;
    for (int64_t task = 0; task < tasks; ++task) {
      const int64_t here = cursor[size_t(task * batch.tiles + tile)];
      cursor[size_t(task * batch.tiles + tile)] = total;
      total += here;
    }
  }
  out.tile_begin[batch.tiles] = total;
  check(total == out.count, "instances counted by project and by bin differ");
  parallel_for(splats.count, grain, [&](int64_t begin, int64_t end) {
    int64_t* next = cursor.data() + begin / grain * batch.tiles;
    for (int64_t k = begin; k < end; ++k) {
      const int32_t s = out.depth_order[k];
      int64_t entry = out.first_of[s];
      visit_tiles(batch, splats, s, [&](int64_t tile) {
        const int64_t place = next[tile]++;
        out.splat[place] = s;
        if (for_backward) out.slot[entry++] = place;
      });
    }
  });
}

template void CpuBackend<float>::bin(const ViewBatch<float>&, const Splats<float>&, bool,
                                     TileInstances<float>&);
template void CpuBackend<double>::bin(const ViewBatch<double>&, const Splats<double>&, bool,
                                      TileInstances<double>&);

}  // namespace tessera
