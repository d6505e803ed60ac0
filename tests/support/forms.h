// The forms of a set of Gaussians over which a test runs, and their names.
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
