// MCMC densification on the device: dead Gaussians become copies of alive ones, copies are added,
// and means take random steps. Weights are whole numbers, so that sums do not depend on their
// order. The formulas are in math/relocation.h and mcmc.h. Source: method B.
#include "kernels/base/errors.h"
#include "kernels/cuda/cuda_backend.h"
#include "kernels/cuda/device_memory.h"
#include "kernels/cuda/launch.cuh"
#include "kernels/cuda/sort.h"
#include "kernels/edits/mcmc.h"

namespace tessera {
namespace {

constexpr int kThreads = 256;

/// The weight of each Gaussian in the draw, and whether it is dead; one copy of each so far.
template <SetForm form>
__global__ void weigh(GaussianSpans<const float> set, double dead_opacity, int32_t* weight,
                      int32_t* dead, int32_t* copies) {
  const int64_t n = linear_index();
  if (n >= set.count) return;
  const double opacity = living_opacity<form>(set, n);
  const bool alive = opacity > dead_opacity;
  weight[n] = alive ? draw_weight(opacity) : 0;
  dead[n] = !alive;
  copies[n] = 1;
}

/// The source of each element. Nothing is copied where all weights are 0.
__global__ void draw(const int64_t* sums, const int32_t* dead, int64_t count, int64_t elements,
                     uint64_t seed, int32_t* copies, int64_t* values, int64_t* moments) {
  const int64_t i = linear_index();
  if (i >= elements) return;
  const bool is_new = i >= count;
  const bool is_copy = is_new || (dead[i] != 0 && sums[count] > 0);
  const int64_t source = is_copy ? drawn_source(sums, count, seed, i) : i;
  if (is_copy) atomicAdd(&copies[source], 1);
  values[i] = source;
  moments[i] = is_new ? -1 : i;
}

template <SetForm form>
__global__ void settle(GaussianSpans<float> set, const int32_t* copies, double least_opacity,
                       int64_t* moments) {
  const int64_t n = linear_index();
  if (n >= set.count || copies[n] == 1) return;
  become_copies<form>(set, n, copies[n], least_opacity);
  moments[n] = -1;
}

template <SetForm form>
__global__ void make_noise(GaussianSpans<float> set, PositionNoise noise) {
  const int64_t n = linear_index();
  if (n < set.count) add_position_noise<form>(set, n, noise);
}

}  // namespace

void CudaBackend::relocate_elements(const GaussianSpans<float>& set, const RelocationRule& rule,
                                    RelocationElements& elements) {
  const int64_t N = set.count, all = N + rule.added;
  elements.values.resize(all);
  elements.moments.resize(all);
  elements.moved = elements.weight = 0;
  check(rule.added == 0 || N > 0, "relocate_elements: no Gaussian to copy");
  if (N == 0) return;
  Scratch scratch(scratch_);
  for (int k = 0; k < 3; ++k) scratch.plan<int32_t>(N);
  for (int k = 0; k < 2; ++k) scratch.plan<int64_t>(N + 1);
  scratch.allocate();
  const Span<int32_t> weight = scratch.take<int32_t>(N), dead = scratch.take<int32_t>(N),
                      copies = scratch.take<int32_t>(N);
  const Span<int64_t> sums = scratch.take<int64_t>(N + 1), deaths = scratch.take<int64_t>(N + 1);

  with_form(set.form, [&](auto form) {
    launch_linear<kThreads>(stream_, "relocate_elements: weigh", weigh<form()>, N, set.view(),
                            rule.dead_opacity, weight.data, dead.data, copies.data);
  });
  exclusive_sums(stream_, Span<const int32_t>(weight), sums, sort_scratch_);
  exclusive_sums(stream_, Span<const int32_t>(dead), deaths, sort_scratch_);
  memory_.copy(&elements.weight, sums.data + N, sizeof(int64_t));
  memory_.copy(&elements.moved, deaths.data + N, sizeof(int64_t));
  if (elements.weight == 0) elements.moved = 0;
  check(rule.added == 0 || elements.weight > 0, "relocate_elements: no Gaussian to copy");
  launch_linear<kThreads>(stream_, "relocate_elements: draw", draw, all, sums.data, dead.data, N,
                          all, rule.seed, copies.data, elements.values.data(),
                          elements.moments.data());
  with_form(set.form, [&](auto form) {
    launch_linear<kThreads>(stream_, "relocate_elements: settle", settle<form()>, N, set,
                            copies.data, rule.least_opacity, elements.moments.data());
  });
}

void CudaBackend::add_position_noise(const GaussianSpans<float>& set, const PositionNoise& noise) {
  if (set.count == 0) return;
  with_form(set.form, [&](auto form) {
    launch_linear<kThreads>(stream_, "add_position_noise: make_noise", make_noise<form()>,
                            set.count, set, noise);
  });
  clock_.add_bytes(kUpdate, 4.0 * double(set.count));  // opacities; most go no further
}

}  // namespace tessera
