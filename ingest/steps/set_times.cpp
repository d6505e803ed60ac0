// Normalises the times of all frames together.
#include "ingest/clocks/timesteps.h"
#include "ingest/steps/steps.h"

namespace tessera {

Capture set_times(Capture capture, const StepContext& context) {
  capture.is_static = true;
  capture.time_axis = capture.stated_axis.value_or(TimeAxis{});
  std::vector<double> stated;
  for (const CaptureFrame& frame : capture.frames) stated.push_back(frame.frame.time);
  NormalisedTimes times{std::vector<double>(stated.size(), 0.0), capture.time_axis, true};
  if (capture.is_timed) {
    const IngestOptions& options = context.options;
    const bool one_timestep =
        options.allow_static || (!capture.clips.empty() && options.frames == 1);
    times = normalise_times(stated, one_timestep, capture.times_from.string());
    if (capture.stated_axis && !times.is_static) times = {stated, *capture.stated_axis, false};
  }
  for (size_t i = 0; i < stated.size(); ++i) capture.frames[i].frame.time = times.time[i];
  capture.time_axis = times.axis;
  capture.is_static = times.is_static;
  return capture;
}

}  // namespace tessera
