// What: that a stage got a truth, a mask and a colour for every view, or none where there may be
// none. Not: their sizes: a span of a device knows only its own.
#pragma once
#include "kernels/backend.h"
#include "kernels/base/errors.h"

namespace tessera {

/// Of masks, for a batch of `views`. Errors: a bug of ours.
inline void check_target(size_t views, const std::vector<Span<const uint8_t>>& mask) {
  check(mask.empty() || mask.size() == views, "one mask per view");
}
template <class Real>
void check_target(const PhotometricArgs<Real>& args) {
  check(args.truth.size() == args.batch->views.size(), "one ground truth per view");
  check_target(args.batch->views.size(), args.mask);
}
template <class Real>
void check_target(const SensitivityArgs<Real>& args) {
  const size_t views = args.pass.forward.batch->views.size();
  check_target(views, args.mask);
  check(args.response.empty() || args.response.size() == views, "one response per view");
}
template <class Real>
void check_target(const ColourMapArgs<Real>& args) {
  check(args.maps.size() == args.batch->views.size(), "one map of colours per view");
}

}  // namespace tessera
