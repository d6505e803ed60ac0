// What: dead Gaussians become copies of living ones, copies are added, means take random steps, on
// the device. Weights are whole numbers and counts are added, so that nothing depends on an order.
// Not: when (recon4d/density/mcmc.h); what becomes of one Gaussian is in math/relocation.h and
// elements/position_noise.h.
// Source: method B.
#include "kernels/base/errors.h"
#include "kernels/cuda/cuda_backend.h"
#include "kernels/cuda/device_error.h"
#include "kernels/cuda/scratch.h"
#include "kernels/cuda/sort.h"
#include "kernels/elements/position_noise.h"
#include "kernels/elements/relocation.h"

namespace tessera {
namespace {

constexpr int kThreads = 256;

/// What each Gaussian weighs in the draw, and whether it is dead; one copy of each so far.
template <Form form>
__global__ void weigh(GaussianSpans<const float> set, double dead_opacity, int32_t* weight,
                      int32_t* dead, int32_t* copies) {
  const int64_t n = int64_t(blockIdx.x) * kThreads + threadIdx.x;
  if (n >= set.count) return;
  const double opacity = living_opacity<form>(set, n);
  const bool lives = opacity > dead_opacity;
  weight[n] = lives ? draw_weight(opacity) : 0;
  dead[n] = !lives;
  copies[n] = 1;
}

/// Where each row comes from. Nobody is copied where all weights are 0.
__global__ void draw(const int64_t* sums, const int32_t* dead, int64_t count, int64_t rows,
                     uint64_t seed, int32_t* copies, int64_t* values, int64_t* moments) {
  const int64_t i = int64_t(blockIdx.x) * kThreads + threadIdx.x;
  if (i >= rows) return;
  const bool is_new = i >= count;
  const bool is_copy = is_new || (dead[i] != 0 && sums[count] > 0);
  const int64_t source = is_copy ? drawn_source(sums, count, seed, i) : i;
  if (is_copy) atomicAdd(&copies[source], 1);
  values[i] = source;
  moments[i] = is_new ? -1 : i;
}

template <Form form>
__global__ void settle(GaussianSpans<float> set, const int32_t* copies, double least_opacity,
                       int64_t* moments) {
  const int64_t n = int64_t(blockIdx.x) * kThreads + threadIdx.x;
  if (n >= set.count || copies[n] == 1) return;
  become_copies<form>(set, n, copies[n], least_opacity);
  moments[n] = -1;
}

template <Form form>
__global__ void make_noise(GaussianSpans<float> set, PositionNoise noise) {
  const int64_t n = int64_t(blockIdx.x) * kThreads + threadIdx.x;
  if (n < set.count) add_position_noise<form>(set, n, noise);
}

}  // namespace

void CudaBackend::relocate_rows(const GaussianSpans<float>& set, const RelocationRule& rule,
                                RelocationRows& rows) {
  const int64_t N = set.count, all = N + rule.added;
  rows.values.resize(all), rows.moments.resize(all);
  rows.moved = rows.weight = 0;
  check(rule.added == 0 || N > 0, "relocate_rows: nobody to copy");
  if (N == 0) return;
  const unsigned grid = grid_of(N, kThreads);
  Scratch scratch(scratch_);
  for (int k = 0; k < 3; ++k) scratch.plan<int32_t>(N);
  for (int k = 0; k < 2; ++k) scratch.plan<int64_t>(N + 1);
  scratch.allocate();
  const Span<int32_t> weight = scratch.take<int32_t>(N), dead = scratch.take<int32_t>(N),
                      copies = scratch.take<int32_t>(N);
  const Span<int64_t> sums = scratch.take<int64_t>(N + 1), deaths = scratch.take<int64_t>(N + 1);

  with_form(set.form, [&](auto form) {
    weigh<form()><<<grid, kThreads, 0, stream_>>>(set.view(), rule.dead_opacity, weight.data,
                                                  dead.data, copies.data);
  });
  check_launch("relocate_rows: weigh");
  exclusive_sums(stream_, Span<const int32_t>(weight), sums, sort_scratch_);
  exclusive_sums(stream_, Span<const int32_t>(dead), deaths, sort_scratch_);
  memory_.copy(&rows.weight, sums.data + N, sizeof(int64_t));
  memory_.copy(&rows.moved, deaths.data + N, sizeof(int64_t));
  if (rows.weight == 0) rows.moved = 0;
  check(rule.added == 0 || rows.weight > 0, "relocate_rows: nobody to copy");
  draw<<<grid_of(all, kThreads), kThreads, 0, stream_>>>(sums.data, dead.data, N, all, rule.seed,
                                                         copies.data, rows.values.data(),
                                                         rows.moments.data());
  check_launch("relocate_rows: draw");
  with_form(set.form, [&](auto form) {
    settle<form()>
        <<<grid, kThreads, 0, stream_>>>(set, copies.data, rule.least_opacity, rows.moments.data());
  });
  check_launch("relocate_rows: settle");
}

void CudaBackend::add_position_noise(const GaussianSpans<float>& set, const PositionNoise& noise) {
  if (set.count == 0) return;
  with_form(set.form, [&](auto form) {
    make_noise<form()><<<grid_of(set.count, kThreads), kThreads, 0, stream_>>>(set, noise);
  });
  check_launch("add_position_noise");
  clock_.add_bytes(kUpdate, 4.0 * double(set.count));  // opacities; most go no further
}

}  // namespace tessera
