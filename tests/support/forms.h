// What: the forms of a set of Gaussians, to run a test over, and their names.
// Not: sets of Gaussians (test_scene.h).
#pragma once
#include "kernels/gaussians.h"

namespace tessera::testing {

inline constexpr SetForm kForms[] = {SetForm::kStatic, SetForm::kPair, SetForm::kVelocity};
inline constexpr SetForm kDynamicForms[] = {SetForm::kPair, SetForm::kVelocity};

inline const char* form_name(SetForm form) {
  constexpr const char* kNames[] = {"static", "pair", "velocity", "canonical"};
  return kNames[size_t(form)];
}

}  // namespace tessera::testing
