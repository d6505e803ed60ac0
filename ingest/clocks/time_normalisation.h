// What: times in the capture's own unit → [0, 1] over all splits, in double.
// Not: where the times come from (presentation timestamps, json), and never a frame index.
#pragma once
#include <string>
#include <vector>

#include "ingest/scene.h"

namespace tessera {

struct NormalisedTimes {
  std::vector<double> time;  // as many as were given, in [0, 1]
  TimeAxis axis;
  bool is_static = false;
};

/// time = (t − min) / (max − min), so t, 2t + 5 and t + 1.7e9 give the same. One time is static.
/// Errors: InputError that starts with `where` when several are given that are all equal, unless
/// `allow_static`.
NormalisedTimes normalise_times(const std::vector<double>& source_times, bool allow_static,
                                const std::string& where);

}  // namespace tessera
