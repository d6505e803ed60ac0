// Groups the frames of a scene into stations: one camera with one pose and one lens. Each pose of a
// moving camera is a separate station.
#pragma once
#include <string>
#include <vector>

#include "ingest/scene.h"

namespace tessera {

struct Station {
  std::string name;  // the camera's, or the frame's where a camera has several poses
  Camera camera;
  Split split = Split::kTrain;
  std::vector<int> frames;  // into Scene::frames, by time
};

/// In the order of the files; a station belongs to one split.
std::vector<Station> stations_of(const Scene& scene);
/// Those of the training split.
std::vector<Station> training_stations(const Scene& scene);

/// The median over time of every pixel and channel: the static background. Needs pixels.
Image8 median_image(const Scene& scene, const Station& station);

/// The mean of 3 × 3 pixels around a place as values in 0–255; no place within the image, or a
/// value of the channel at or beyond the sensor's ends (<= 5 or >= 250): −1.
std::array<double, 3> colour_at(const Image8& image, double x, double y);

/// Where the camera sees the point, in pixels; false behind it or outside of the image.
bool project_into(const Camera& camera, const glm::dvec3& point, double& x, double& y);

}  // namespace tessera
