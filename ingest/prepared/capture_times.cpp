// What: the choice between three cases: no times, times to normalise, times of a prepared scene.
// Not: a guess: a capture with some times missing was refused while parsing.
#include "ingest/prepared/capture_times.h"

#include <fmt/format.h>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

void check_prepared(const TransformsCapture& capture) {
  if (!(capture.prepared_axis->duration > 0))
    throw InputError(fmt::format(
        "{}: tessera.time.duration is {}, expected more than 0; prepare the capture again",
        capture.files.front().string(), capture.prepared_axis->duration));
  for (const TransformsFrame& frame : capture.frames)
    if (frame.time.value_or(0) < 0 || frame.time.value_or(0) > 1)
      throw InputError(fmt::format(
          "{}: time is {}, a prepared scene has times from 0 to 1; prepare the capture again",
          frame.where, *frame.time));
}

}  // namespace

NormalisedTimes times_of(const TransformsCapture& capture, bool allow_static) {
  if (capture.prepared_axis) check_prepared(capture);
  const bool has_times = capture.frames.front().time.has_value();
  if (!has_times || capture.prepared_static)
    return {std::vector<double>(capture.frames.size(), 0.0),
            capture.prepared_axis.value_or(TimeAxis{}), true};
  std::vector<double> times;
  for (const TransformsFrame& frame : capture.frames) times.push_back(*frame.time);
  NormalisedTimes normalised = normalise_times(times, allow_static, capture.files.front().string());
  if (capture.prepared_axis && !normalised.is_static)
    return {std::move(times), *capture.prepared_axis, false};
  return normalised;
}

}  // namespace tessera
