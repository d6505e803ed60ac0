// What: density control of a set as lists of rows, and the order of a set in memory, on the device.
// Not: when (recon4d/training/schedule.h); the rule for one Gaussian is in elements/density.h.
// Source: method A.13, A.14, D.7.
#include <cub/device/device_reduce.cuh>

#include "kernels/base/errors.h"
#include "kernels/cuda/cuda_backend.h"
#include "kernels/cuda/device_error.h"
#include "kernels/cuda/scratch.h"
#include "kernels/cuda/sort.h"
#include "kernels/elements/density.h"
#include "kernels/math/locality.h"

namespace tessera {
namespace {

constexpr int kThreads = 256;

/// 1 in `alive`, and the key by which candidates are ranked: strongest first, those that are none
/// last.
__global__ void rate(DensityLimits<float> limits, GaussianSpans<const float> set,
                     DensityStatistics<const float> statistics, int32_t* alive, uint32_t* key,
                     int32_t* number, int32_t* candidate) {
  const int64_t n = int64_t(blockIdx.x) * kThreads + threadIdx.x;
  if (n >= set.count) return;
  const bool lives = is_alive(limits, set, n);
  const float score = growth_score(statistics.gradient_sum[n], statistics.count[n]);
  const bool grows = lives && score >= limits.threshold;
  alive[n] = lives;
  candidate[n] = grows;
  key[n] = grows ? ~__float_as_uint(score) : ~0u;  // bits of positive floats order as they do
  number[n] = int32_t(n);
}

/// Candidates beyond the room are none.
__global__ void drop_weak(const int32_t* ranked, int64_t first, int64_t count, int32_t* candidate) {
  const int64_t i = first + int64_t(blockIdx.x) * kThreads + threadIdx.x;
  if (i < count) candidate[ranked[i]] = 0;
}

/// Counts that the scans place: survivors, clones, parents.
__global__ void decide(DensityLimits<float> limits, GaussianSpans<const float> set,
                       const int32_t* alive, const int32_t* candidate, int32_t* kept,
                       int32_t* cloned, int32_t* split) {
  const int64_t n = int64_t(blockIdx.x) * kThreads + threadIdx.x;
  if (n >= set.count) return;
  const Fate fate = alive[n] != 0 ? fate_of(limits, set, n, candidate[n] != 0) : Fate::kRemoved;
  kept[n] = fate == Fate::kKept || fate == Fate::kCloned;
  cloned[n] = fate == Fate::kCloned;
  split[n] = fate == Fate::kSplit;
}

struct Places {
  const int64_t *kept, *cloned, *split;  // [N+1] exclusive sums
  int64_t first_clone, first_child, children;
};

__global__ void list_rows(Places places, int64_t count, int64_t* index) {
  const int64_t n = int64_t(blockIdx.x) * kThreads + threadIdx.x;
  if (n >= count) return;
  if (places.kept[n + 1] > places.kept[n]) index[places.kept[n]] = n;
  if (places.cloned[n + 1] > places.cloned[n]) index[places.first_clone + places.cloned[n]] = n;
  if (places.split[n + 1] > places.split[n]) {
    index[places.first_child + places.split[n]] = n;
    index[places.first_child + places.children + places.split[n]] = n;
  }
}

template <Form form>
__global__ void place(GaussianSpans<float> set, int64_t first, uint64_t seed) {
  const int64_t n = first + int64_t(blockIdx.x) * kThreads + threadIdx.x;
  if (n < set.count) place_child<form>(set, n, seed);
}

struct WidenBox {
  __host__ __device__ LocalityBox operator()(LocalityBox a, const LocalityBox& b) const {
    for (int k = 0; k < 4; ++k) {
      a.low[k] = min_of(a.low[k], b.low[k]);
      a.high[k] = max_of(a.high[k], b.high[k]);
    }
    return a;
  }
};

__global__ void boxes_of(GaussianSpans<const float> set, LocalityBox* boxes) {
  const int64_t n = int64_t(blockIdx.x) * kThreads + threadIdx.x;
  if (n >= set.count) return;
  const float* m = set.at(kMean, n);
  const float t = set.dim() == 4 ? *set.at(kMeanTime, n) : 0.0f;
  boxes[n] = {{m[0], m[1], m[2], t}, {m[0], m[1], m[2], t}};
}

__global__ void locality_keys(GaussianSpans<const float> set, const LocalityBox* box,
                              uint64_t* morton, uint16_t* bin, int32_t* number) {
  const int64_t n = int64_t(blockIdx.x) * kThreads + threadIdx.x;
  if (n >= set.count) return;
  const float* m = set.at(kMean, n);
  morton[n] = morton_code(*box, m[0], m[1], m[2]);
  bin[n] = set.dim() == 4 ? uint16_t(time_bin(*box, *set.at(kMeanTime, n))) : uint16_t(0);
  number[n] = int32_t(n);
}

__global__ void bins_in_order(const uint16_t* bin, const int32_t* order, int64_t count,
                              uint16_t* out) {
  const int64_t i = int64_t(blockIdx.x) * kThreads + threadIdx.x;
  if (i < count) out[i] = bin[order[i]];
}

__global__ void widen(const int32_t* from, int64_t count, int64_t* to) {
  const int64_t i = int64_t(blockIdx.x) * kThreads + threadIdx.x;
  if (i < count) to[i] = from[i];
}

}  // namespace

void CudaBackend::select_rows(const GaussianSpans<const float>& set,
                              const DensityStatistics<const float>& statistics,
                              const DensityRule& rule, DensityRows& rows) {
  const int64_t N = set.count;
  const unsigned grid = grid_of(N, kThreads);
  const DensityLimits<float> limits = density_limits<float>(rule);
  Scratch scratch(scratch_);
  for (int k = 0; k < 5; ++k) scratch.plan<int32_t>(N);
  for (int k = 0; k < 4; ++k) scratch.plan<uint32_t>(N);
  for (int k = 0; k < 3; ++k) scratch.plan<int64_t>(N + 1);
  scratch.allocate();
  const Span<int32_t> alive = scratch.take<int32_t>(N), candidate = scratch.take<int32_t>(N);
  Span<int32_t> flags[3];
  for (Span<int32_t>& flag : flags) flag = scratch.take<int32_t>(N);
  const Span<uint32_t> keys = scratch.take<uint32_t>(N), sorted = scratch.take<uint32_t>(N);
  const Span<int32_t> number = scratch.take<int32_t>(N), ranked = scratch.take<int32_t>(N);
  Span<int64_t> sums[3];
  for (Span<int64_t>& sum : sums) sum = scratch.take<int64_t>(N + 1);

  rate<<<grid, kThreads, 0, stream_>>>(limits, set, statistics, alive.data, keys.data, number.data,
                                       candidate.data);
  if (rule.room >= 0) {
    exclusive_sums(stream_, Span<const int32_t>(alive), sums[0], sort_scratch_);
    int64_t living = 0;
    memory_.copy(&living, sums[0].data + N, sizeof(living));
    const int64_t room = rule.room + N - living;
    sort_pairs(stream_, Span<const uint32_t>(keys), Span<const int32_t>(number), 32, sorted, ranked,
               sort_scratch_);
    if (room < N)
      drop_weak<<<grid_of(N - room, kThreads), kThreads, 0, stream_>>>(ranked.data, room, N,
                                                                       candidate.data);
  }
  decide<<<grid, kThreads, 0, stream_>>>(limits, set, alive.data, candidate.data, flags[0].data,
                                         flags[1].data, flags[2].data);
  check_launch("select_rows");
  int64_t totals[3] = {};
  for (int k = 0; k < 3; ++k) {
    exclusive_sums(stream_, Span<const int32_t>(flags[k]), sums[k], sort_scratch_);
    memory_.copy(&totals[k], sums[k].data + N, sizeof(int64_t));
  }
  rows.survivors = totals[0], rows.clones = totals[1], rows.parents = totals[2];
  rows.pruned = N - totals[0] - totals[2];
  rows.index.resize(totals[0] + totals[1] + 2 * totals[2]);
  list_rows<<<grid, kThreads, 0, stream_>>>(
      {sums[0].data, sums[1].data, sums[2].data, totals[0], totals[0] + totals[1], totals[2]}, N,
      rows.index.data());
  check_launch("select_rows: list_rows");
}

void CudaBackend::place_children(const GaussianSpans<float>& set, int64_t first, uint64_t seed) {
  const int64_t count = set.count - first;
  if (count <= 0) return;
  with_form(set.form, [&](auto form) {
    place<form()><<<grid_of(count, kThreads), kThreads, 0, stream_>>>(set, first, seed);
  });
  check_launch("place_children");
}

void CudaBackend::locality_order(const GaussianSpans<const float>& set, Buffer<int64_t>& order) {
  const int64_t N = set.count;
  order.resize(N);
  if (N == 0) return;
  const unsigned grid = grid_of(N, kThreads);
  Scratch scratch(scratch_);
  scratch.plan<LocalityBox>(N), scratch.plan<LocalityBox>(1);
  for (int k = 0; k < 2; ++k) scratch.plan<uint64_t>(N), scratch.plan<uint16_t>(N);
  for (int k = 0; k < 3; ++k) scratch.plan<int32_t>(N);
  scratch.allocate();
  const Span<LocalityBox> boxes = scratch.take<LocalityBox>(N), box = scratch.take<LocalityBox>(1);
  const Span<uint64_t> morton = scratch.take<uint64_t>(N);
  const Span<uint16_t> bin = scratch.take<uint16_t>(N);
  const Span<uint64_t> sorted = scratch.take<uint64_t>(N);
  const Span<uint16_t> bins = scratch.take<uint16_t>(N);
  const Span<int32_t> number = scratch.take<int32_t>(N), by_place = scratch.take<int32_t>(N),
                      by_time = scratch.take<int32_t>(N);
  boxes_of<<<grid, kThreads, 0, stream_>>>(set, boxes.data);
  constexpr float kMost = 3e38f;
  const LocalityBox nothing{{kMost, kMost, kMost, kMost}, {-kMost, -kMost, -kMost, -kMost}};
  size_t bytes = 0;
  check_device(cub::DeviceReduce::Reduce(nullptr, bytes, boxes.data, box.data, N, WidenBox{},
                                         nothing, stream_),
               "reduce");
  sort_scratch_.resize(int64_t(bytes));
  check_device(cub::DeviceReduce::Reduce(sort_scratch_.data(), bytes, boxes.data, box.data, N,
                                         WidenBox{}, nothing, stream_),
               "reduce");
  locality_keys<<<grid, kThreads, 0, stream_>>>(set, box.data, morton.data, bin.data, number.data);
  sort_pairs(stream_, Span<const uint64_t>(morton), Span<const int32_t>(number), 3 * kMortonBits,
             sorted, by_place, sort_scratch_);
  const bool timed = set.dim() == 4;
  if (timed) {
    bins_in_order<<<grid, kThreads, 0, stream_>>>(bin.data, by_place.data, N, bins.data);
    sort_pairs(stream_, Span<const uint16_t>(bins), Span<const int32_t>(by_place),
               bits_of(kTimeBins), bin, by_time, sort_scratch_);
  }
  widen<<<grid, kThreads, 0, stream_>>>(timed ? by_time.data : by_place.data, N, order.data());
  check_launch("locality_order");
}

}  // namespace tessera
