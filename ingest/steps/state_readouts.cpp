// Readouts of rolling shutters: those that a calibration or --readout states, in the image that is
// shown upright.
#include <fmt/format.h>

#include <algorithm>

#include "ingest/steps/steps.h"
#include "ingest/test_views.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

void check_names(const std::map<std::string, double>& readouts, const Capture& capture) {
  std::vector<std::string> names;
  for (const RigClip& clip : capture.clips) names.push_back(clip.name);
  for (const auto& [name, seconds] : readouts)
    if (!name.empty() && std::find(names.begin(), names.end(), name) == names.end())
      throw InputError(
          fmt::format("--readout names {}, but the cameras are {}", name, listed_names(names)));
}

}  // namespace

Capture state_readouts(Capture capture, const StepContext& context) {
  const std::map<std::string, double>& stated = context.options.readouts;
  check_names(stated, capture);
  std::vector<std::string> turned;
  for (RigClip& clip : capture.clips) {
    if (!clip.camera) continue;
    double& readout = clip.camera->camera.readout;
    const auto by_name = stated.find(clip.name), of_all = stated.find("");
    if (by_name != stated.end())
      readout = by_name->second;
    else if (of_all != stated.end())
      readout = of_all->second;
    if (readout == 0) continue;
    if (clip.timeline.quarter_turns == 2) readout = -readout;
    if (clip.timeline.quarter_turns % 2 == 0) continue;
    readout = 0;
    turned.push_back(clip.name);
  }
  if (!turned.empty())
    capture.warnings.push_back(
        fmt::format("{}: filmed upright, so the sensor's rows are columns of the image, whose "
                    "rolling shutter is not modelled; film with the phone on its side",
                    listed_names(turned)));
  return capture;
}

}  // namespace tessera
