// What: a thinned load, the fit, and all training images divided by their camera's gains.
// Not: the fit (checks/exposure.h).
#include "ingest/media/layouts/exposure_conversion.h"

#include <fmt/format.h>

#include <map>

#include "ingest/files/png.h"
#include "ingest/media/checks/exposure.h"
#include "ingest/media/checks/thinned_scene.h"
#include "ingest/media/layouts/conversion.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

using Gains = std::map<std::string, std::array<double, 3>>;  // by camera

Gains gains_of(const Scene& sample) {
  const std::vector<Station> stations = training_stations(sample);
  if (stations.size() < 2)
    throw InputError("--fit-exposure compares cameras, and there is one; leave it out");
  for (const Station& station : stations)
    if (station.name != sample.frames[size_t(station.frames.front())].camera_name)
      throw InputError(
          fmt::format("--fit-exposure compares cameras that stand still, and '{}' moves; leave it "
                      "out",
                      sample.frames[size_t(station.frames.front())].camera_name));
  Gains gains;
  for (const CameraGain& camera : fit_exposure(match_stations(sample)))
    gains[camera.camera] = camera.gain;
  return gains;
}

}  // namespace

void even_exposure(const std::filesystem::path& folder, PreparedScene& scene,
                   const IngestProgress& progress) {
  Thinning thinning;
  thinning.stations = int(scene.frames.size());  // all
  const Gains gains = gains_of(thinned_scene(folder, thinning).sample);
  for (PreparedCamera& camera : scene.cameras) {
    const auto found = gains.find(camera.name);
    camera.exposure_gain = found == gains.end() ? std::array<double, 3>{1, 1, 1} : found->second;
  }
  convert_images(scene.frames.size(), progress, [&](size_t i) {
    const PreparedFrame& prepared = scene.frames[i];
    const auto found = gains.find(prepared.frame.camera_name);
    if (prepared.frame.split != Split::kTrain || found == gains.end()) return;
    Image8 image = read_png(folder / prepared.file_path);
    apply_exposure(image, found->second);
    write_png(folder / prepared.file_path, image);
  });
}

}  // namespace tessera
