// Density control of a set on the device as lists of elements, the children of splits, and the
// order of a set in memory. The rule for one Gaussian is in density.h. Source: method A.13, A.14,
// D.7.
#include <thrust/iterator/counting_iterator.h>

#include <cub/device/device_reduce.cuh>

#include "kernels/base/errors.h"
#include "kernels/cuda/cuda_backend.h"
#include "kernels/cuda/device_memory.h"
#include "kernels/cuda/device_sum.cuh"
#include "kernels/cuda/launch.cuh"
#include "kernels/cuda/sort.h"
#include "kernels/edits/density.h"
#include "kernels/math/sort_keys.h"

namespace tessera {
namespace {

constexpr int kThreads = 256;

/// 1 in `alive`, and the key by which candidates are ranked; those that are none come last.
__global__ void rate(DensityLimits<float> limits, GaussianSpans<const float> set,
                     DensityStatistics<const float> statistics, int32_t* alive, uint32_t* key,
                     int32_t* number, int32_t* candidate) {
  const int64_t n = linear_index();
  if (n >= set.count) return;
  const float score = candidate_score(limits, set, statistics, n);
  const bool grows = score >= 0;
  alive[n] = grows || is_alive(limits, set, n);
  candidate[n] = grows;
  key[n] = grows ? growth_key(limits, score, n) : ~0u;
  number[n] = int32_t(n);
}

/// Candidates beyond the room are none.
__global__ void drop_weak(const int32_t* ranked, int64_t first, int64_t count, int32_t* candidate) {
  const int64_t i = first + linear_index();
  if (i < count) candidate[ranked[i]] = 0;
}

/// Counts that the scans place: survivors, clones, parents.
__global__ void decide(DensityLimits<float> limits, GaussianSpans<const float> set,
                       const int32_t* alive, const int32_t* candidate, int32_t* kept,
                       int32_t* cloned, int32_t* split) {
  const int64_t n = linear_index();
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

__global__ void list_elements(Places places, int64_t count, int64_t* index) {
  const int64_t n = linear_index();
  if (n >= count) return;
  if (places.kept[n + 1] > places.kept[n]) index[places.kept[n]] = n;
  if (places.cloned[n + 1] > places.cloned[n]) index[places.first_clone + places.cloned[n]] = n;
  if (places.split[n + 1] > places.split[n]) {
    index[places.first_child + places.split[n]] = n;
    index[places.first_child + places.children + places.split[n]] = n;
  }
}

template <SetForm form>
__global__ void place(GaussianSpans<float> set, int64_t first, SplitRule rule) {
  const int64_t n = first + linear_index();
  if (n < set.count) place_child<form>(set, first, n, rule);
}

struct CandidateWeight {
  DensityLimits<float> limits;
  GaussianSpans<const float> set;
  DensityStatistics<const float> statistics;

  __device__ double operator()(int64_t n) const {
    return double(max_of(candidate_score(limits, set, statistics, n), 0.0f));
  }
};

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
  const int64_t n = linear_index();
  if (n >= set.count) return;
  const float* m = set.at(kMean, n);
  const float t = set.dim() == 4 ? *set.at(kMeanTime, n) : 0.0f;
  boxes[n] = {{m[0], m[1], m[2], t}, {m[0], m[1], m[2], t}};
}

__global__ void locality_keys(GaussianSpans<const float> set, const LocalityBox* box,
                              uint64_t* morton, uint16_t* bin, int32_t* number) {
  const int64_t n = linear_index();
  if (n >= set.count) return;
  const float* m = set.at(kMean, n);
  morton[n] = morton_code(*box, m[0], m[1], m[2]);
  bin[n] = set.dim() == 4 ? uint16_t(time_bin(*box, *set.at(kMeanTime, n))) : uint16_t(0);
  number[n] = int32_t(n);
}

__global__ void bins_in_order(const uint16_t* bin, const int32_t* order, int64_t count,
                              uint16_t* out) {
  const int64_t i = linear_index();
  if (i < count) out[i] = bin[order[i]];
}

__global__ void widen(const int32_t* from, int64_t count, int64_t* to) {
  const int64_t i = linear_index();
  if (i < count) to[i] = from[i];
}

}  // namespace

void CudaBackend::select_elements(const GaussianSpans<const float>& set,
                                  const DensityStatistics<const float>& statistics,
                                  const DensityRule& rule, DensityElements& elements) {
  const int64_t N = set.count;
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

  launch_linear<kThreads>(stream_, "select_elements: rate", rate, N, limits, set, statistics,
                          alive.data, keys.data, number.data, candidate.data);
  if (rule.room >= 0) {
    exclusive_sums(stream_, Span<const int32_t>(alive), sums[0], sort_scratch_);
    int64_t living = 0;
    memory_.copy(&living, sums[0].data + N, sizeof(living));
    const int64_t room = rule.room + N - living;
    sort_pairs(stream_, Span<const uint32_t>(keys), Span<const int32_t>(number), 32, sorted, ranked,
               sort_scratch_);
    if (room < N)
      launch_linear<kThreads>(stream_, "select_elements: drop_weak", drop_weak, N - room,
                              ranked.data, room, N, candidate.data);
  }
  launch_linear<kThreads>(stream_, "select_elements: decide", decide, N, limits, set, alive.data,
                          candidate.data, flags[0].data, flags[1].data, flags[2].data);
  int64_t totals[3] = {};
  for (int k = 0; k < 3; ++k) {
    exclusive_sums(stream_, Span<const int32_t>(flags[k]), sums[k], sort_scratch_);
    memory_.copy(&totals[k], sums[k].data + N, sizeof(int64_t));
  }
  elements.survivors = totals[0];
  elements.clones = totals[1];
  elements.parents = totals[2];
  elements.pruned = N - totals[0] - totals[2];
  elements.index.resize(totals[0] + totals[1] + 2 * totals[2]);
  const Places places{sums[0].data, sums[1].data,          sums[2].data,
                      totals[0],    totals[0] + totals[1], totals[2]};
  launch_linear<kThreads>(stream_, "select_elements: list_elements", list_elements, N, places, N,
                          elements.index.data());
}

double CudaBackend::growth_weight(const GaussianSpans<const float>& set,
                                  const DensityStatistics<const float>& statistics,
                                  const DensityRule& rule) {
  const CandidateWeight weight{density_limits<float>(rule), set, statistics};
  return device_sum(stream_, thrust::counting_iterator<int64_t>(0), set.count, weight, scratch_,
                    sort_scratch_, memory_, "growth_weight");
}

void CudaBackend::place_children(const GaussianSpans<float>& set, int64_t first,
                                 const SplitRule& rule) {
  const int64_t count = set.count - first;
  if (count <= 0) return;
  with_form(set.form, [&](auto form) {
    launch_linear<kThreads>(stream_, "place_children: place", place<form()>, count, set, first,
                            rule);
  });
}

void CudaBackend::locality_order(const GaussianSpans<const float>& set, Buffer<int64_t>& order) {
  const int64_t N = set.count;
  order.resize(N);
  if (N == 0) return;
  Scratch scratch(scratch_);
  scratch.plan<LocalityBox>(N);
  scratch.plan<LocalityBox>(1);
  for (int k = 0; k < 2; ++k) {
    scratch.plan<uint64_t>(N);
    scratch.plan<uint16_t>(N);
  }
  for (int k = 0; k < 3; ++k) scratch.plan<int32_t>(N);
  scratch.allocate();
  const Span<LocalityBox> boxes = scratch.take<LocalityBox>(N), box = scratch.take<LocalityBox>(1);
  const Span<uint64_t> morton = scratch.take<uint64_t>(N);
  const Span<uint16_t> bin = scratch.take<uint16_t>(N);
  const Span<uint64_t> sorted = scratch.take<uint64_t>(N);
  const Span<uint16_t> bins = scratch.take<uint16_t>(N);
  const Span<int32_t> number = scratch.take<int32_t>(N), by_place = scratch.take<int32_t>(N),
                      by_time = scratch.take<int32_t>(N);
  launch_linear<kThreads>(stream_, "locality_order: boxes_of", boxes_of, N, set, boxes.data);
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
  launch_linear<kThreads>(stream_, "locality_order: locality_keys", locality_keys, N, set, box.data,
                          morton.data, bin.data, number.data);
  sort_pairs(stream_, Span<const uint64_t>(morton), Span<const int32_t>(number), 3 * kMortonBits,
             sorted, by_place, sort_scratch_);
  const bool timed = set.dim() == 4;
  if (timed) {
    launch_linear<kThreads>(stream_, "locality_order: bins_in_order", bins_in_order, N, bin.data,
                            by_place.data, N, bins.data);
    sort_pairs(stream_, Span<const uint16_t>(bins), Span<const int32_t>(by_place),
               bits_of(kTimeBins), bin, by_time, sort_scratch_);
  }
  launch_linear<kThreads>(stream_, "locality_order: widen", widen, N,
                          timed ? by_time.data : by_place.data, N, order.data());
}

}  // namespace tessera
