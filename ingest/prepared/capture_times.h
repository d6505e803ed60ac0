// What: the times of a transforms capture, normalised, or kept where a prepared scene states them.
// Not: the arithmetic (time_normalisation.h).
#pragma once
#include "ingest/clocks/time_normalisation.h"
#include "ingest/prepared/transforms_json.h"

namespace tessera {

/// One entry a frame of `capture`. Without times the capture is static. Errors: InputError: times
/// all equal (unless `allow_static`), or a prepared scene whose times or axis cannot be.
NormalisedTimes times_of(const TransformsCapture& capture, bool allow_static);

}  // namespace tessera
