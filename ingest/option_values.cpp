// Checks the values of ingest options that are wrong for any capture.
#include <fmt/format.h>

#include "ingest/ingest.h"

namespace tessera {
namespace {

void check_positive(const std::optional<double>& value, const char* option) {
  if (value && !(*value > 0))
    throw InputError(fmt::format("{} is {}, expected more than 0", option, *value));
}

}  // namespace

void check_values(const IngestOptions& options) {
  if (!(options.scale > 0 && options.scale <= 1))
    throw InputError(
        fmt::format("--scale is {}, expected more than 0 and at most 1; pass 0.5 for "
                    "images of half the width",
                    options.scale));
  if (options.frames && *options.frames < 1)
    throw InputError(
        fmt::format("--frames is {}, expected at least 1; leave it out for all", *options.frames));
  if (!(options.start >= 0))
    throw InputError(fmt::format("--start is {}, expected 0 or more", options.start));
  check_positive(options.duration, "--duration");
  check_positive(options.fps, "--fps");
  if (options.cloud_points < 1)
    throw InputError(
        fmt::format("--cloud-points is {}, expected at least 1; pass --cloud none for "
                    "no points",
                    options.cloud_points));
}

}  // namespace tessera
