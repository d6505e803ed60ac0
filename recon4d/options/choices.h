// Options of enumerations, and the one table of the names of their values.
#pragma once
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <vector>

#include "kernels/batch.h"
#include "kernels/gaussians.h"

namespace tessera {

/// How a scene moves in its model. kAuto is decided before a training starts: kNodes or kPair.
enum class Motion { kAuto, kNone, kPair, kVelocity, kNodes };
/// Of each of the short trainings by which that is decided; images have about as many pixels at
/// most.
inline constexpr int64_t kTrialIterations = 2000, kTrialBatch = 4, kTrialPixels = 400 * 400;
enum class Filter3d { kNone, kMip, kClamp };
/// kAuto is decided before a training starts: kCamera where the cameras differ, else kNone.
enum class ExposureGains { kNone, kCamera, kAffine, kFrame, kAuto };
enum class Densification { kAdc, kBudget, kMcmc };
/// A part of Densification::kBudget.
enum class GrowthPart { kNone, kLongAxisSplit, kGrowthBudget, kWeightedDraw, kAbsoluteGradient };
enum class ModelSize { kGrown, kKnee };

/// Names of the values of an enumeration, in their order.
template <class Enum>
inline constexpr std::nullptr_t kChoiceNames = nullptr;
template <>
inline constexpr const char* kChoiceNames<Motion>[] = {"auto", "none", "pair", "velocity", "nodes"};
template <>
inline constexpr const char* kChoiceNames<Filter3d>[] = {"none", "mip", "clamp"};
template <>
inline constexpr const char* kChoiceNames<ExposureGains>[] = {"none", "camera", "affine", "frame",
                                                              "auto"};
template <>
inline constexpr const char* kChoiceNames<IdleUpdate>[] = {"dense", "skip"};
template <>
inline constexpr const char* kChoiceNames<Densification>[] = {"adc", "budget", "mcmc"};
template <>
inline constexpr const char* kChoiceNames<GrowthPart>[] = {
    "none", "long-axis-split", "growth-budget", "weighted-draw", "absolute-gradient"};
template <>
inline constexpr const char* kChoiceNames<ModelSize>[] = {"grown", "knee"};
template <>
inline constexpr const char* kChoiceNames<BackwardForm>[] = {"sub-tile", "pixel"};

template <class Enum>
constexpr const char* name_of(Enum value) {
  return kChoiceNames<Enum>[size_t(value)];
}
/// Form of the dynamic set.
constexpr SetForm dynamic_form_of(Motion motion) {
  return motion == Motion::kVelocity ? SetForm::kVelocity : SetForm::kPair;
}
/// Name of the form of a dynamic set, as files have it.
constexpr const char* dynamic_form_name(SetForm form) {
  return name_of(form == SetForm::kVelocity ? Motion::kVelocity : Motion::kPair);
}
template <class Enum>
std::vector<const char*> choice_names() {
  return {std::begin(kChoiceNames<Enum>), std::end(kChoiceNames<Enum>)};
}

}  // namespace tessera
