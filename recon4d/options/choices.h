// Options of enumerations, and the names of their values.
#pragma once
#include <cstdint>
#include <iterator>
#include <vector>

#include "kernels/base/enum_names.h"
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
/// kAuto is decided before a training starts: kLearn where they were measured.
enum class Clocks { kFixed, kLearn, kAuto };
enum class Densification { kAdc, kBudget, kMcmc };
/// A part of Densification::kBudget.
enum class GrowthPart { kNone, kLongAxisSplit, kGrowthBudget, kWeightedDraw, kAbsoluteGradient };
enum class ModelSize { kGrown, kKnee };

template <>
inline constexpr const char* kEnumNames<Motion>[] = {"auto", "none", "pair", "velocity", "nodes"};
template <>
inline constexpr const char* kEnumNames<Filter3d>[] = {"none", "mip", "clamp"};
template <>
inline constexpr const char* kEnumNames<ExposureGains>[] = {"none", "camera", "affine", "frame",
                                                            "auto"};
template <>
inline constexpr const char* kEnumNames<Clocks>[] = {"fixed", "learn", "auto"};
template <>
inline constexpr const char* kEnumNames<IdleUpdate>[] = {"dense", "skip"};
template <>
inline constexpr const char* kEnumNames<Densification>[] = {"adc", "budget", "mcmc"};
template <>
inline constexpr const char* kEnumNames<GrowthPart>[] = {"none", "long-axis-split", "growth-budget",
                                                         "weighted-draw", "absolute-gradient"};
template <>
inline constexpr const char* kEnumNames<ModelSize>[] = {"grown", "knee"};
template <>
inline constexpr const char* kEnumNames<BackwardForm>[] = {"sub-tile", "pixel"};

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
  return {std::begin(kEnumNames<Enum>), std::end(kEnumNames<Enum>)};
}

}  // namespace tessera
