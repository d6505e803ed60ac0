// Reads the boxes of a ground_truth.json, and scales them to the size of a frame.
#include "tools/commands/object_boxes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "ingest/files/json_file.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

using nlohmann::json;

/// The boxes of each frame of a camera from {name: [[x0, y0, x1, y1] or null, one a frame]}.
std::vector<NamedBoxes> camera_boxes(const json& objects) {
  std::vector<NamedBoxes> frames;
  for (const auto& [name, boxes] : objects.items()) {
    frames.resize(std::max(frames.size(), boxes.size()));
    for (size_t frame = 0; frame < boxes.size(); ++frame) {
      const json& box = boxes.at(frame);
      if (box.is_null()) continue;
      frames[frame][name] = {box.at(0).get<int>(), box.at(1).get<int>(), box.at(2).get<int>(),
                             box.at(3).get<int>()};
    }
  }
  return frames;
}

}  // namespace

ObjectBoxes::ObjectBoxes(const std::filesystem::path& file) : file_(file.string()) {
  const json truth = read_json(file);
  try {
    width_ = truth.at("intrinsics").at("w").get<double>();
    height_ = truth.at("intrinsics").at("h").get<double>();
    for (const json& camera : truth.at("cameras"))
      if (std::vector<NamedBoxes> boxes = camera_boxes(camera.at("boxes")); !boxes.empty())
        cameras_[camera.at("name").get<std::string>()] = std::move(boxes);
  } catch (const json::exception&) {
    cameras_.clear();
  }
  if (cameras_.empty() || !(width_ > 0 && height_ > 0))
    throw InputError(fmt::format(
        "{}: has no boxes of objects; pass the ground_truth.json of a scene with movers that "
        "`tessera synth` has written with the layout n3dv or videos",
        file_));
}

void ObjectBoxes::check_fits(const Scene& scene, const std::vector<Split>& splits) const {
  std::map<std::string, size_t> frames;  // of a camera, over all splits
  for (const Frame& frame : scene.frames) ++frames[frame.camera_name];
  for (const Frame& frame : scene.frames) {
    if (std::find(splits.begin(), splits.end(), frame.split) == splits.end()) continue;
    const auto camera = cameras_.find(frame.camera_name);
    if (camera == cameras_.end())
      throw InputError(fmt::format(
          "{}: has no camera {}; pass the ground_truth.json of the capture that {} was made from",
          file_, frame.camera_name, scene.path));
    const size_t expected = frames[frame.camera_name];
    const bool numbered = frame.frame_number >= 0 && frame.frame_number < int64_t(expected);
    if (camera->second.size() != expected || !numbered)
      throw InputError(fmt::format(
          "{}: has {} frames of {}, the scene {} has {}; prepare the scene with all frames", file_,
          camera->second.size(), frame.camera_name, scene.path, expected));
  }
}

NamedBoxes ObjectBoxes::of(const Frame& frame) const {
  NamedBoxes boxes = cameras_.at(frame.camera_name).at(size_t(frame.frame_number));
  const double x = frame.image.width / width_, y = frame.image.height / height_;
  for (auto& [name, box] : boxes)
    box = {int(std::floor(x * box.x0)), int(std::floor(y * box.y0)), int(std::ceil(x * box.x1)),
           int(std::ceil(y * box.y1))};
  return boxes;
}

}  // namespace tessera
