// What: the refusal of counts that do not fit the 32-bit numbers which lists of a batch hold.
// Not: a limit of memory: that is the allocation's error.
#pragma once
#include <cstdint>
#include <string>

#include "kernels/base/errors.h"

namespace tessera {

/// Errors: InputError where more than 2³¹ − 1 of `what` are to be numbered.
inline void check_count(int64_t count, const char* what, const char* remedy) {
  if (count <= INT32_MAX) return;
  throw InputError(std::to_string(count) + " " + what + " in one batch, at most " +
                   std::to_string(INT32_MAX) + " are supported; use " + remedy);
}

inline void check_gaussian_count(int64_t count) {
  check_count(count, "Gaussians", "fewer (--max-gaussians)");
}
inline void check_splat_count(int64_t count) {
  check_count(count, "splats", "a smaller batch or fewer Gaussians (--max-gaussians)");
}

}  // namespace tessera
