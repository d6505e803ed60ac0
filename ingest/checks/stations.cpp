// Groups frames by camera, pose and split, and computes median images over time and the colours at
// image positions.
#include "ingest/checks/stations.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "kernels/base/median.h"

namespace tessera {
namespace {

using PoseKey = std::array<double, 16>;

PoseKey key_of(const Camera& camera) {
  PoseKey key{camera.fl_x, camera.fl_y, camera.cx, camera.cy};
  for (int c = 0; c < 3; ++c) {
    for (int r = 0; r < 3; ++r) key[size_t(4 + 3 * c + r)] = camera.cam_from_world[c][r];
    key[size_t(13 + c)] = camera.translation[c];
  }
  return key;
}

}  // namespace

std::vector<Station> stations_of(const Scene& scene) {
  std::map<std::tuple<std::string, Split, PoseKey>, size_t> places;
  std::map<std::string, std::set<PoseKey>> poses_of_camera;
  std::vector<Station> stations;
  for (int i = 0; i < int(scene.frames.size()); ++i) {
    const Frame& frame = scene.frames[size_t(i)];
    const PoseKey pose = key_of(frame.camera);
    poses_of_camera[frame.camera_name].insert(pose);
    const auto [place, is_new] =
        places.try_emplace({frame.camera_name, frame.split, pose}, stations.size());
    if (is_new) stations.push_back({frame.camera_name, frame.camera, frame.split, {}});
    stations[place->second].frames.push_back(i);
  }
  for (Station& station : stations) {
    std::stable_sort(station.frames.begin(), station.frames.end(), [&](int a, int b) {
      return scene.frames[size_t(a)].time < scene.frames[size_t(b)].time;
    });
    if (poses_of_camera[station.name].size() > 1)
      station.name = scene.frames[size_t(station.frames.front())].name;
  }
  return stations;
}

std::vector<Station> training_stations(const Scene& scene) {
  std::vector<Station> stations = stations_of(scene);
  std::erase_if(stations, [](const Station& s) { return s.split != Split::kTrain; });
  return stations;
}

Image8 median_image(const Scene& scene, const Station& station) {
  Image8 median = scene.frames[size_t(station.frames.front())].image;
  if (station.frames.size() < 3) return median;
  std::vector<uint8_t> values(station.frames.size());
  for (size_t k = 0; k < median.data.size(); ++k) {
    for (size_t i = 0; i < values.size(); ++i)
      values[i] = scene.frames[size_t(station.frames[i])].image.data[k];
    median.data[k] = median_in_place(values);
  }
  return median;
}

std::array<double, 3> colour_at(const Image8& image, double x, double y) {
  const int column = int(std::floor(x)), row = int(std::floor(y));
  std::array<double, 3> colour{-1, -1, -1};
  if (column < 1 || row < 1 || column + 1 >= image.width || row + 1 >= image.height) return colour;
  for (size_t k = 0; k < 3; ++k) {
    int sum = 0, low = 255, high = 0;
    for (int v = row - 1; v <= row + 1; ++v)
      for (int u = column - 1; u <= column + 1; ++u) {
        const int value = image.data[(size_t(v) * size_t(image.width) + size_t(u)) * 3 + k];
        sum += value;
        low = std::min(low, value);
        high = std::max(high, value);
      }
    if (low > 5 && high < 250) colour[k] = sum / 9.0;
  }
  return colour;
}

bool project_into(const Camera& camera, const glm::dvec3& point, double& x, double& y) {
  const glm::dvec3 seen = camera.cam_from_world * point + camera.translation;
  if (!(seen.z > 1e-9)) return false;
  x = camera.fl_x * seen.x / seen.z + camera.cx;
  y = camera.fl_y * seen.y / seen.z + camera.cy;
  return x >= 0 && y >= 0 && x < camera.width && y < camera.height;
}

}  // namespace tessera
