// What: the forms of a set of Gaussians, to run a test over, and their names.
// Not: sets of Gaussians (test_scene.h).
#pragma once
#include "kernels/gaussians.h"

namespace tessera::testing {

inline constexpr Form kForms[] = {Form::kStatic, Form::kPair, Form::kVelocity};
inline constexpr Form kDynamicForms[] = {Form::kPair, Form::kVelocity};

inline const char* form_name(Form form) {
  constexpr const char* kNames[] = {"static", "pair", "velocity", "canonical"};
  return kNames[size_t(form)];
}

}  // namespace tessera::testing
