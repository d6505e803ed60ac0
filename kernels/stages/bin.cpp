// Splats to tile instances on the CPU: one order by depth, then a stable counting sort by tile.
// Source: depth-then-tile sort of [Splatshop], [Faster-GS]; method A.9.
#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"
#include "kernels/cpu_backend.h"
#include "kernels/math/sort_keys.h"
#include "kernels/stages/radix_order.h"

namespace tessera {
namespace {

/// Splats of a task; the histogram of each task costs one counter per tile.
constexpr int64_t kMinGrain = 16384;
constexpr int64_t kMaxTasks = 16;

template <class Real, class Visit>
void visit_tiles(const BinArgs<Real>& args, int64_t s, Visit&& visit) {
  const Splat<Real>& splat = args.splats->splat[s];
  const ViewArgs<Real>& view = args.batch->views[size_t(splat.view)];
  for_each_tile(args.splats->rect[s], view.tiles_x,
                [&](int tile) { visit(view.first_tile + tile); });
}

}  // namespace

template <class Real>
void CpuBackend<Real>::bin(const BinArgs<Real>& args, TileInstances<Real>& out) {
  const ViewBatch<Real>& batch = *args.batch;
  const Splats<Real>& splats = *args.splats;
  check_splat_count(splats.count);
  const Real near_plane = Real(args.options.near_plane);
  radix_order([&](int64_t s) { return depth_key(splats.depth[s], near_plane); }, splats.count,
              out.depth_order);
  out.first_of.resize(splats.count);
  out.count = 0;
  for (int64_t s = 0; s < splats.count; ++s) {
    out.first_of[s] = out.count;
    out.count += splats.tiles[s];
  }
  out.splat.resize(out.count);
  out.slot.resize(args.for_backward ? out.count : 0);
  out.tile_begin.resize(batch.tiles + 1);

  const int64_t grain = max_of(kMinGrain, (splats.count + kMaxTasks - 1) / kMaxTasks);
  const int64_t tasks = (splats.count + grain - 1) / grain;
  std::vector<int64_t> cursor(static_cast<size_t>(tasks * batch.tiles), 0);
  parallel_for(splats.count, grain, [&](int64_t begin, int64_t end) {
    int64_t* histogram = cursor.data() + begin / grain * batch.tiles;
    for (int64_t k = begin; k < end; ++k)
      visit_tiles(args, out.depth_order[k], [&](int64_t tile) { ++histogram[tile]; });
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
      visit_tiles(args, s, [&](int64_t tile) {
        const int64_t place = next[tile]++;
        out.splat[place] = s;
        if (args.for_backward) out.slot[entry++] = place;
      });
    }
  });
}

template void CpuBackend<float>::bin(const BinArgs<float>&, TileInstances<float>&);
template void CpuBackend<double>::bin(const BinArgs<double>&, TileInstances<double>&);

}  // namespace tessera
