// The parameters of a set of Gaussians as kernels read them: named groups of spans. GaussianSet
// (recon4d/model/gaussian_set.h) owns the memory.
#pragma once
#include <cassert>
#include <cstdint>
#include <type_traits>
#include <utility>

#include "kernels/base/buffer.h"
#include "kernels/math/adam.h"
#include "kernels/math/carry.h"
#include "kernels/sh_blocks.h"

namespace tessera {

/// How a set stores its Gaussians: the template axis of all that comes before the slice in time.
/// Both forms of Dim 4 are the same family (static3d/transform/motion_form.h converts).
enum class SetForm : uint8_t {
  kStatic,     // Dim 3
  kPair,       // Dim 4: two quaternions and four scales of space-time  [Yang24]
  kVelocity,   // Dim 4: quaternion and scales of the slice, velocity, temporal scale  [FreeTimeGS]
  kCanonical,  // Dim 3 at rest, carried by motion nodes through time  (method D.9)
};

/// Whether a set's Gaussians have times of their own.
TESSERA_HD inline constexpr bool is_dynamic(SetForm form) {
  return form == SetForm::kPair || form == SetForm::kVelocity;
}
TESSERA_HD inline constexpr int dim_of(SetForm form) {
  return is_dynamic(form) ? 4 : 3;
}

/// visit(form) with the form as a type: `form()` is a constant inside. A canonical set is static
/// here: as it lies at rest.
template <class Visit>
decltype(auto) with_form(SetForm form, Visit&& visit) {
  if (form == SetForm::kPair) return visit(std::integral_constant<SetForm, SetForm::kPair>{});
  if (form == SetForm::kVelocity)
    return visit(std::integral_constant<SetForm, SetForm::kVelocity>{});
  return visit(std::integral_constant<SetForm, SetForm::kStatic>{});
}

/// The same for the stages that draw, to which a canonical set is a form of its own.
template <class Visit>
decltype(auto) with_drawn_form(SetForm form, Visit&& visit) {
  if (form == SetForm::kCanonical)
    return visit(std::integral_constant<SetForm, SetForm::kCanonical>{});
  return with_form(form, std::forward<Visit>(visit));
}

/// Parameter groups in storage order, of which each form has a first part (group_count). Groups in
/// it that a form does not use have no scalars, as kShTime in a set without levels of time.
/// kRotationRight is what couples space and time, and differs between the forms of Dim 4.
enum Group : int {
  kMean,           // [N, 3] world units
  kLogScale,       // [N, 3] ln of world units
  kRotation,       // [N, 4] quaternion w,x,y,z; of a pair: the left one
  kOpacityLogit,   // [N]
  kSh,             // [N, K, 3] spherical harmonics, RGB innermost
  kMeanTime,       // [N] normalised time
  kLogScaleTime,   // [N] ln of normalised time
  kRotationRight,  // [N, 4] of a pair
  kShTime,         // [N, L, K, 3] levels of time of the colour (math/spherindrical.h)
  kNodeLogit,      // [N, kBindings] of the weight of each node that a Gaussian is bound to
  kNode,           // [N, kBindings] numbers of these nodes, −1: none; not optimised
  kGroupCount,
  kVelocity = kRotationRight  // [N, 3] world units per unit of normalised time, in its place
};
inline constexpr int kStaticGroups = 5, kDynamicGroups = 9;

inline constexpr int group_count(SetForm form) {
  return form == SetForm::kCanonical ? kGroupCount
                                     : (is_dynamic(form) ? kDynamicGroups : kStaticGroups);
}

/// The stored name: `rotation` is `rotation_left` in a pair.
inline const char* group_name(Group group, SetForm form) {
  constexpr const char* kNames[kGroupCount] = {
      "mean",           "log_scale",      "rotation", "opacity_logit", "sh",  "mean_time",
      "log_scale_time", "rotation_right", "sh_time",  "node_logit",    "node"};
  if (form == SetForm::kVelocity && group == kVelocity) return "velocity";
  return form == SetForm::kPair && group == kRotation ? "rotation_left" : kNames[group];
}

/// Groups that keep both moments of a scalar in one word of `moment1`, where scalars are floats;
/// `moment2` of them is empty  (kernels/math/adam.h).
TESSERA_HD inline constexpr bool packs_moments(Group group) {
  return group == kSh || group == kShTime;
}
/// Buffers of Adam's moments of a group, which are `moment1` and `moment2`; those of 0 are not
/// optimised.
inline constexpr int moment_buffers(Group group) {
  return group == kNode ? 0 : (packs_moments(group) ? 1 : 2);
}

/// Scalars per Gaussian of a group; `coefficients` = K, `time_levels` = L.
TESSERA_HD inline constexpr int group_width(Group group, int coefficients, SetForm form,
                                            int time_levels = 0) {
  switch (group) {
    case kMean:
    case kLogScale:
      return 3;
    case kRotation:
      return 4;
    case kOpacityLogit:
      return 1;
    case kSh:
      return 3 * coefficients;
    case kMeanTime:
    case kLogScaleTime:
      return form == SetForm::kCanonical ? 0 : 1;
    case kRotationRight:
      return form == SetForm::kCanonical ? 0 : (form == SetForm::kVelocity ? 3 : 4);
    case kShTime:
      return 3 * coefficients * time_levels;
    default:
      return form == SetForm::kCanonical ? kBindings : 0;
  }
}

/// Scalars per Gaussian of all groups but the two of SH: 11, 17, 16 or 27.
inline constexpr int geometry_scalars(SetForm form) {
  int sum = 0;
  for (int g = 0; g < group_count(form); ++g)
    if (g != kSh) sum += group_width(Group(g), 0, form);
  return sum;
}

/// The same with the moments of these scalars.
inline constexpr int trained_geometry_scalars(SetForm form) {
  int sum = 0;
  for (int g = 0; g < group_count(form); ++g)
    if (g != kSh) sum += group_width(Group(g), 0, form) * (1 + moment_buffers(Group(g)));
  return sum;
}

/// `count` values from `first` on; of an empty span none.
template <class T>
Span<T> part_of(Span<T> all, int64_t first, int64_t count) {
  if (all.empty()) return {};
  assert(first >= 0 && count >= 0 && first + count <= all.size);
  return {all.data + first, count};
}

template <class T>
struct GaussianSpans {
  SetForm form = SetForm::kStatic;
  int64_t count = 0;      // N
  int coefficients = 16;  // K, the most that an element has
  int time_levels = 0;    // L; 0 in Dim 3
  Span<T> group[kGroupCount];
  Span<T> filter_size;  // [N] φ of the 3D filter that is applied, world units; empty: none is
  ShBlocks blocks;      // where elements differ in K
  /// [B, carried_stride] of a canonical set that is drawn: Gaussian n in view b.
  const CarriedGaussian<std::remove_const_t<T>>* carried = nullptr;
  int64_t carried_stride = 0;

  TESSERA_HD int dim() const { return dim_of(form); }
  TESSERA_HD int width(Group g) const { return group_width(g, coefficients, form, time_levels); }

  /// First scalar of Gaussian n in a group; of kSh and kShTime in a set whose elements are alike,
  /// e.g. in a block.
  TESSERA_HD T* at(Group g, int64_t n) const {
    assert(!blocks.mixed() || (g != kSh && g != kShTime));
    return group[g].data + n * width(g);
  }
  /// The elements of a block, as a set whose elements are alike.
  GaussianSpans block(const ShBlock& block) const {
    GaussianSpans out = *this;
    out.count = block.count;
    out.coefficients = block.coefficients;
    out.blocks = {};
    for (int g = 0; g < kGroupCount; ++g) {
      const bool colour = g == kSh || g == kShTime;
      const int64_t scalars = group_width(Group(g), 1, form, time_levels);
      out.group[g] =
          colour ? part_of(group[g], block.sh_first * scalars, out.width(Group(g)) * out.count)
                 : part_of(group[g], block.first * scalars, scalars * out.count);
    }
    out.filter_size = part_of(filter_size, block.first, block.count);
    if (carried != nullptr) out.carried = carried + block.first;
    return out;
  }
  /// The same, not to be written.
  TESSERA_HD GaussianSpans<const T> view() const {
    GaussianSpans<const T> out;
    out.form = form;
    out.count = count;
    out.coefficients = coefficients;
    out.time_levels = time_levels;
    out.blocks = blocks;
    for (int g = 0; g < kGroupCount; ++g) out.group[g] = group[g];
    out.filter_size = filter_size;
    out.carried = carried;
    out.carried_stride = carried_stride;
    return out;
  }
};

/// Step sizes of every group; the first SH coefficient has its own. Levels of time have sh_rest.
template <class Real>
struct AdamGroups {
  AdamScalars<Real> group[kGroupCount];  // kSh: coefficient 0; kShTime: not used
  AdamScalars<Real> sh_rest;             // coefficients 1 … K−1
};

/// What the fused optimizer does for a Gaussian that no view of the batch sees.
enum class IdleUpdate {
  kDense,  // its step with a zero gradient, like any other: the trajectory of plain Adam
  kSkip,   // nothing  [Taming]: not the trajectory of plain Adam
};

/// Terms of the loss that each Gaussian adds by its parameters alone, not in the losses that are
/// reported: means over the Gaussians of both sets. A view's loss has those of the static Gaussians
/// that it draws; those of dynamic Gaussians are there whether any view draws them or not, but for
/// IdleUpdate::kSkip  [method B].
struct RegulariserWeights {
  double opacity = 0;  // of mean σ(logit)
  double scale = 0;    // of mean e^{s̃}, world units, over the three axes in space of each
};

/// Where a set's gradients go. With `fused` they are consumed by Adam where they arise.
template <class Real>
struct SinkArgs {
  bool fused = false;
  GaussianSpans<Real> gradient;                 // StoreGradient: written, not added to
  GaussianSpans<Real> value, moment1, moment2;  // ApplyAdam
  AdamGroups<Real> adam;                        // ApplyAdam
  IdleUpdate idle = IdleUpdate::kDense;         // ApplyAdam

  /// Of the elements of a block.
  SinkArgs block(const ShBlock& block) const {
    SinkArgs out = *this;
    for (GaussianSpans<Real>* spans : {&out.gradient, &out.value, &out.moment1, &out.moment2})
      *spans = spans->block(block);
    return out;
  }
};

/// Densification statistic of a set, accumulated over batches  [method D.6].
template <class Real>
struct DensityStatistics {
  /// [N] Σ over batches of the mean over views of ‖dL/d mean2D‖ in NDC.
  Span<Real> gradient_sum;
  Span<Real> count;  // [N] batches in which it was visible
  /// Share of the sum, over pixels, of the lengths of what they add to that gradient, which counts
  /// in its place where it is larger: what pixels want of a large Gaussian may cancel. 1: always
  /// [AbsGS].
  Real length_share = Real(0);

  /// Of the elements of a block.
  DensityStatistics block(const ShBlock& block) const {
    return {part_of(gradient_sum, block.first, block.count),
            part_of(count, block.first, block.count), length_share};
  }
};

/// When a Gaussian is removed, cloned or split  [method A.13].
struct DensityRule {
  double threshold = 0;      // least statistic of one that grows
  double prune_opacity = 0;  // less opaque ones are removed
  double largest_clone = 0;  // world units; larger ones are split
  double largest_kept = 0;   // world units; larger ones are removed; 0: none
  int64_t room = -1;         // Gaussians that may be added to the set; < 0: no limit
  bool halves = false;       // children are halves (SplitRule)
  bool drawn = false;        // where room is short: in proportion to the statistic, not strongest
  uint64_t seed = 0;         // of that draw
};

/// The children of a split: halves of their parent along its longest axis, or samples of it.
struct SplitRule {
  bool halves = false;
  uint64_t seed = 0;  // of the samples
};

/// The opacity up to which Gaussians are dead, and how many copies are added  [method B].
struct RelocationRule {
  double dead_opacity = 0;   // not more opaque ones are dead, as are those that are no Gaussians
  double least_opacity = 0;  // of a Gaussian that was copied, and of its copies
  int64_t added = 0;         // elements behind the last one
  uint64_t seed = 0;
};

/// What elements of a set are taken from when Gaussians have been relocated.
struct RelocationElements {
  explicit RelocationElements(Memory& memory = host_memory()) : values(memory), moments(memory) {}

  Buffer<int64_t> values;   // [N + added] element of the values
  Buffer<int64_t> moments;  // [N + added] element of the moments; −1: zeros
  int64_t moved = 0;        // dead ones that became copies
  int64_t weight = 0;       // Σ draw_weight of those that were alive
};

/// Noise of the means, one draw for each Gaussian and step  [method B].
struct PositionNoise {
  double scale = 0;  // of Σ·ξ, per world unit
  uint64_t seed = 0;
  int64_t step = 0;
};

/// The elements of a set that make up the next one: survivors, clones, first and second children.
struct DensityElements {
  explicit DensityElements(Memory& memory = host_memory()) : index(memory) {}

  Buffer<int64_t> index;
  int64_t survivors = 0, clones = 0, parents = 0, pruned = 0;
};

}  // namespace tessera
