// What: that a stage got a truth, a mask and a gain for every view, or none where there may be
// none. Not: their sizes: a span of a device knows only its own.
#pragma once
#include "kernels/backend.h"
#include "kernels/base/errors.h"

namespace tessera {

/// Of masks and gains, for a batch of `views`. Errors: a bug of ours.
inline void check_target(size_t views, const std::vector<Span<const uint8_t>>& mask,
                         const std::vector<Vec3<double>>& gain) {
  check(mask.empty() || mask.size() == views, "one mask per view");
  check(gain.empty() || gain.size() == views, "one gain per view");
}
template <class Real>
void check_target(const PhotometricArgs<Real>& args) {
  check(args.truth.size() == args.batch->views.size(), "one ground truth per view");
  check_target(args.batch->views.size(), args.mask, args.gain);
}
template <class Real>
void check_target(const SensitivityArgs<Real>& args) {
  check_target(args.pass.forward.batch->views.size(), args.mask, args.gain);
}

}  // namespace tessera
