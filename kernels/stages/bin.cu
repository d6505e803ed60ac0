// Splats to tile instances on the device: one order by depth, then a stable sort by tile. Small
// splats write their tiles from one lane, large ones from the whole warp. Source: depth-then-tile
// sort of [Splatshop], [Faster-GS]; method A.8, A.9.
#include "kernels/base/errors.h"
#include "kernels/cuda/cuda_backend.h"
#include "kernels/cuda/device_memory.h"
#include "kernels/cuda/launch.cuh"
#include "kernels/cuda/sort.h"
#include "kernels/math/bounds.h"
#include "kernels/math/sort_keys.h"

namespace tessera {
namespace {

constexpr int kThreads = 128;

/// Splats with more tiles than this are shared by the warp.
constexpr int kOwnTiles = 8;

/// All lanes of a warp call this together; a lane without a splat passes an empty rect.
/// Small splats: visit(tile) for each tile, by the lane itself. Large ones: 32 tiles at a time,
/// shared(owner, listed, tile, place) by all lanes together, `place` counted from the owner's first
/// tile; lanes behind its last one are not `listed`.
template <class Visit, class Shared>
__device__ void walk_tiles(bool balanced, const TileRect& rect, int tiles_x, Visit&& visit,
                           Shared&& shared) {
  const int area = rect.empty() ? 0 : rect.area();
  const bool large = balanced && area > kOwnTiles;
  if (!large) for_each_tile(rect, tiles_x, visit);
  const int lane = int(threadIdx.x % 32);
  for (unsigned owners = __ballot_sync(~0u, large); owners != 0; owners &= owners - 1) {
    const int owner = __ffs(int(owners)) - 1;
    const auto from = [owner](int value) { return __shfl_sync(~0u, value, owner); };
    const int x0 = from(rect.x0), y0 = from(rect.y0), width = from(rect.x1) - x0;
    const int tiles = from(area), row = from(tiles_x);
    for (int begin = 0; begin < tiles; begin += 32) {
      const int place = begin + lane;
      shared(owner, place < tiles, (y0 + place / width) * row + x0 + place % width, place);
    }
  }
}

__global__ void depth_keys(const float* depth, float near_plane, int64_t count, uint32_t* key,
                           int32_t* number) {
  const int64_t s = linear_index();
  if (s >= count) return;
  key[s] = depth_key(depth[s], near_plane);
  number[s] = int32_t(s);
}

/// Where instances go: `key` by tile, `value` what the sort carries along.
template <class Key>
struct InstanceTarget {
  Key* key;
  int32_t* value;
  int32_t* splat_of;   // null: the value is the splat; else the value is the entry's number
  const float* depth;  // its key is below the tile's where keys have 64 bits
  float near_plane;

  __device__ void write(int64_t entry, int64_t tile, int32_t s) const {
    if constexpr (sizeof(Key) == 8)
      key[entry] = Key(tile) << 32 | Key(depth_key(depth[s], near_plane));
    else
      key[entry] = Key(tile);
    value[entry] = splat_of != nullptr ? int32_t(entry) : s;
    if (splat_of != nullptr) splat_of[entry] = s;
  }
};

/// The splat of rank r in `order` (null: as they stand) writes its tiles from offset[r] on.
template <class Key>
__global__ void __launch_bounds__(kThreads)
    write_instances(bool balanced, const ViewArgs<float>* views, const Splat<float>* splats,
                    const TileRect* rects, const int32_t* order, const int64_t* offset,
                    int64_t count, InstanceTarget<Key> target, int64_t* first_of) {
  const int64_t r = linear_index();
  const bool on = r < count;
  const int32_t s = on ? (order != nullptr ? order[r] : int32_t(r)) : 0;
  TileRect rect{};
  int64_t entry = 0, first_tile = 0;
  int tiles_x = 0;
  if (on) {
    const ViewArgs<float>& view = views[splats[s].view];
    rect = rects[s];
    entry = offset[r];
    first_tile = view.first_tile;
    tiles_x = view.tiles_x;
    if (first_of != nullptr) first_of[s] = entry;
  }
  const int64_t begin = entry;
  walk_tiles(
      balanced, rect, tiles_x, [&](int tile) { target.write(entry++, first_tile + tile, s); },
      [&](int owner, bool listed, int tile, int place) {
        const int64_t their_entry = __shfl_sync(~0u, begin, owner) + place;
        const int64_t their_tile = __shfl_sync(~0u, first_tile, owner) + tile;
        const int32_t their_splat = __shfl_sync(~0u, s, owner);
        if (listed) target.write(their_entry, their_tile, their_splat);
      });
}

/// begin[t] = first sorted instance of a tile ≥ t.
template <class Key>
__global__ void find_tiles(const Key* keys, int64_t count, int64_t tiles, int64_t* begin) {
  const int64_t i = linear_index();
  if (i > count) return;
  const auto tile = [keys](int64_t k) {
    return sizeof(Key) == 8 ? int64_t(uint64_t(keys[k]) >> 32) : int64_t(keys[k]);
  };
  const int64_t from = i == 0 ? -1 : tile(i - 1), to = i == count ? tiles : tile(i);
  for (int64_t t = from + 1; t <= to; ++t) begin[t] = i;
}

constexpr int kOrderThreads = 1024, kLengths = 256;

/// A class of a list's length, long ones first: in sixteenths, all that are longer together.
__device__ inline int length_class(const int64_t* tile_begin, int64_t tile) {
  const int64_t length = tile_begin[tile + 1] - tile_begin[tile];
  return kLengths - 1 - int(min(int64_t{kLengths - 1}, (length + 15) / 16));
}

/// Place of each lane with `asks` among those of its class, with those before in `count`.
__device__ inline int place_in_class(int* count, int length, bool asks) {
  const unsigned asking = __ballot_sync(~0u, asks);
  if (!asks) return 0;
  const unsigned alike = __match_any_sync(asking, length);
  const int lane = int(threadIdx.x) % 32, first = __ffs(int(alike)) - 1;
  const int before = __popc(alike & ((1u << lane) - 1));
  int begin = 0;
  if (lane == first) begin = atomicAdd(count + length, __popc(alike));
  return __shfl_sync(alike, begin, first) + before;
}

/// Tiles by classes of length, in one block: of a few thousand numbers a sort would spend its time
/// on launches. Those of one class stand in any order.
__global__ void __launch_bounds__(kOrderThreads)
    order_tiles_of(const int64_t* tile_begin, int64_t tiles, int32_t* order) {
  __shared__ int count[kLengths];
  const int thread = int(threadIdx.x);
  if (thread < kLengths) count[thread] = 0;
  __syncthreads();
  const auto for_each_tile = [&](auto&& visit) {
    for (int64_t first = 0; first < tiles; first += kOrderThreads) {
      const int64_t tile = first + thread;
      const bool listed = tile < tiles;
      visit(tile, listed ? length_class(tile_begin, tile) : 0, listed);
    }
  };
  for_each_tile([&](int64_t, int length, bool listed) { place_in_class(count, length, listed); });
  __syncthreads();
  int before = 0;
  for (int k = 0; k < min(thread, kLengths); ++k) before += count[k];
  __syncthreads();
  if (thread < kLengths) count[thread] = before;
  __syncthreads();
  for_each_tile([&](int64_t tile, int length, bool listed) {
    const int place = place_in_class(count, length, listed);
    if (listed) order[place] = int32_t(tile);
  });
}

/// Sorted entry numbers → splats, and where each entry went.
__global__ void resolve_entries(const int32_t* sorted, const int32_t* splat_of, int64_t count,
                                int32_t* splat, int64_t* slot) {
  const int64_t i = linear_index();
  if (i >= count) return;
  const int32_t entry = sorted[i];
  splat[i] = splat_of[entry];
  slot[entry] = i;
}

}  // namespace

/// The part of `bin` that depends on the width of the keys.
template <class Key>
void CudaBackend::bin_with(const BinArgs<float>& args, TileInstances<float>& out) {
  const Splats<float>& splats = *args.splats;
  const KernelSwitches& switches = args.options.kernels;
  const bool slots = args.for_backward && switches.deterministic;
  const bool separate = sizeof(Key) < 8;
  const float near_plane = float(args.options.near_plane);
  const int64_t S = splats.count, I = out.count;
  Scratch scratch(scratch_);
  scratch.plan<Key>(I);
  scratch.plan<Key>(I);
  scratch.plan<int32_t>(I);
  if (slots) {
    scratch.plan<int32_t>(I);
    scratch.plan<int32_t>(I);
  }
  scratch.plan<int64_t>(S + 1);
  if (separate) {
    for (int k = 0; k < 2; ++k) scratch.plan<uint32_t>(S);
    scratch.plan<int32_t>(S);
  }
  scratch.allocate();
  const Span<Key> keys = scratch.take<Key>(I), sorted = scratch.take<Key>(I);
  const Span<int32_t> values = scratch.take<int32_t>(I);
  const Span<int32_t> splat_of = slots ? scratch.take<int32_t>(I) : Span<int32_t>();
  const Span<int32_t> entries = slots ? scratch.take<int32_t>(I) : Span<int32_t>();
  const Span<int64_t> offsets = scratch.take<int64_t>(S + 1);
  if (separate) {
    const Span<uint32_t> depth = scratch.take<uint32_t>(S), in_order = scratch.take<uint32_t>(S);
    const Span<int32_t> numbers = scratch.take<int32_t>(S);
    launch_linear<256>(stream_, "bin: depth_keys", depth_keys, S, splats.depth.data(), near_plane,
                       S, depth.data, numbers.data);
    sort_pairs(stream_, Span<const uint32_t>(depth), numbers, kDepthKeyBits, in_order,
               out.depth_order.span(), sort_scratch_);
    exclusive_sums(stream_, splats.tiles.span(), out.depth_order.span(), offsets, sort_scratch_);
  } else {
    exclusive_sums(stream_, splats.tiles.span(), offsets, sort_scratch_);
  }
  const InstanceTarget<Key> target{keys.data, values.data, splat_of.data, splats.depth.data(),
                                   near_plane};
  launch_linear<kThreads>(stream_, "bin: write_instances", write_instances<Key>, S,
                          switches.balanced_instances, views_of(*args.batch), splats.splat.data(),
                          splats.rect.data(), separate ? out.depth_order.data() : nullptr,
                          offsets.data, S, target, slots ? out.first_of.data() : nullptr);
  const int bits = bits_of(args.batch->tiles) + (separate ? 0 : 32);
  const Span<int32_t> carried = slots ? entries : out.splat.span();
  sort_pairs(stream_, Span<const Key>(keys), Span<const int32_t>(values), bits, sorted, carried,
             sort_scratch_);
  launch_linear<256>(stream_, "bin: find_tiles", find_tiles<Key>, I + 1, sorted.data, I,
                     args.batch->tiles, out.tile_begin.data());
  if (slots)
    launch_linear<256>(stream_, "bin: resolve_entries", resolve_entries, I, entries.data,
                       splat_of.data, I, out.splat.data(), out.slot.data());
  const double passes = std::ceil(bits / 8.0);
  clock_.add_bytes(kBin, double(S) * (12 + 3 * 8 * 2 + 16 + 48 + 16) +
                             double(I) * (sizeof(Key) + 4) * (1 + 2 * passes));
}

void CudaBackend::order_tiles(TileInstances<float>& out) {
  const int64_t tiles = out.tile_begin.size() - 1;
  out.tile_order.resize(tiles);
  order_tiles_of<<<1, kOrderThreads, 0, stream_>>>(out.tile_begin.data(), tiles,
                                                   out.tile_order.data());
  check_launch("bin: order_tiles_of");
}

void CudaBackend::bin(const BinArgs<float>& args, TileInstances<float>& out) {
  const Splats<float>& splats = *args.splats;
  const bool slots = args.for_backward && args.options.kernels.deterministic;
  check_splat_count(splats.count);
  out.count = splats.instances;
  if (out.count > INT32_MAX)
    throw DeviceError("the splats of this batch touch " + std::to_string(out.count) +
                      " tiles, more than 2147483647; use a smaller batch or smaller images");
  out.splat.resize(out.count);
  out.tile_begin.resize(args.batch->tiles + 1);
  out.depth_order.resize(splats.count);
  out.first_of.resize(slots ? splats.count : 0);
  out.slot.resize(slots ? out.count : 0);
  constexpr int64_t kShort = 1 << 16;
  check(args.batch->tiles <= int64_t{1} << 31, "tiles of a batch fit 31 bits of a key");
  if (!args.options.kernels.separate_sort)
    bin_with<uint64_t>(args, out);
  else if (args.batch->tiles <= kShort)
    bin_with<uint16_t>(args, out);
  else
    bin_with<uint32_t>(args, out);
  order_tiles(out);
}

}  // namespace tessera
