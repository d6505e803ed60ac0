// The cameras that a pixel is compared with, the check from another camera, and the test for
// changes over time.
#include "ingest/cloud/plane_sweep.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "ingest/clocks/timesteps.h"
#include "ingest/cloud/ray_search.h"
#include "kernels/base/parallel.h"

namespace tessera {
namespace {

constexpr double kNearest = 0.25, kFarthest = 4;  // of the distance to the rig's focus
constexpr double kPixelsAPlane = 1.5;             // most that a pixel moves in a median neighbour
constexpr int kFewestPlanes = 48;
constexpr float kLeastTexture = 2;     // of a patch, levels
constexpr float kMostDifference = 12;  // of agreeing patches, levels
constexpr float kMostUnlike = 0.7f;    // of agreeing patches, by their texture
constexpr double kSamePoint = 1.5;     // pixels between a point and where the other camera has it

/// make(i), as far as there is one, in the order of i below `count`.
template <class Value>
std::vector<Value> all_of(int64_t count, const std::function<std::optional<Value>(int64_t)>& make) {
  constexpr int64_t kGrain = 16;  // pixels
  std::vector<std::optional<Value>> made(static_cast<size_t>(count));
  parallel_for(count, kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) made[size_t(i)] = make(i);
  });
  std::vector<Value> found;
  for (const std::optional<Value>& value : made)
    if (value) found.push_back(*value);
  return found;
}

}  // namespace

struct PlaneSweep::Depth {
  double inverse;       // of the depth along the camera's axis
  int best;             // frame that agrees most
  float cost;           // levels
  glm::dvec3 point;     // world units
  glm::dvec3 velocity;  // world units per unit of normalised time
};

PlaneSweep::PlaneSweep(const Scene& scene)
    : PlaneSweep(scene, std::make_shared<const StillPixels>(scene)) {}

PlaneSweep::PlaneSweep(const Scene& scene, std::shared_ptr<const StillPixels> still_pixels)
    : scene_(scene),
      rig_(make_camera_rig(scene.training_cameras())),
      still_pixels_(std::move(still_pixels)) {
  for (const Timestep& timestep : training_timesteps(scene))
    if (timestep.frames.size() >= 3) choose_neighbours(timestep.frames);
  for (const int frame : usable_) {
    grey_[frame] = {};
    light_[frame] = {};
  }
  parallel_for(int64_t(usable_.size()), 1, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) {
      const int index = usable_[size_t(i)];
      const Frame& frame = scene.frames[size_t(index)];
      grey_.at(index) = grey_image(frame.image);
      light_.at(index) = still_pixels_->light_of(frame);
    }
  });
}

/// The cameras that stand nearest: the more they differ, the less they see of the same side.
void PlaneSweep::choose_neighbours(const std::vector<int>& frames) {
  for (int frame : frames) {
    const glm::dvec3 eye = scene_.frames[size_t(frame)].camera.position();
    std::vector<std::pair<double, int>> others;
    for (int other : frames)
      if (other != frame)
        others.emplace_back(glm::distance(eye, scene_.frames[size_t(other)].camera.position()),
                            other);
    std::sort(others.begin(), others.end());
    others.resize(std::min(others.size(), RaySearch::kMostSights));
    for (const auto& [distance, other] : others) neighbours_[frame].push_back(other);
    usable_.push_back(frame);
  }
}

bool PlaneSweep::expect_motion_of(const std::vector<SweptPoint>& points) {
  ExpectedMotion expected(scene_, usable_, points);
  if (expected.largest_shift() <= kLeastShift) return false;
  expected_ = std::move(expected);
  return true;
}

std::optional<PlaneSweep::Depth> PlaneSweep::search(const SweptPixel& pixel) const {
  std::optional<Depth> found = search(pixel, glm::dvec3(0));
  const auto velocity = expected_ ? expected_->at(pixel.frame, pixel.x, pixel.y) : std::nullopt;
  if (!velocity) return found;
  const std::optional<Depth> moving = search(pixel, *velocity);
  return moving && (!found || moving->cost < found->cost) ? moving : found;
}

std::optional<PlaneSweep::Depth> PlaneSweep::search(const SweptPixel& pixel,
                                                    const glm::dvec3& velocity) const {
  const auto [index, x, y] = pixel;
  const Frame& frame = scene_.frames[size_t(index)];
  if (!has_patch(frame.image, x, y) || frame.mask.ignores(x, y)) return std::nullopt;
  const Patch patch = patch_at(frame.image, x, y);
  const float structure = texture(patch);
  if (structure < kLeastTexture) return std::nullopt;
  const Camera& camera = frame.camera;
  const glm::dmat3 world_from_cam = glm::transpose(camera.cam_from_world);
  const glm::dvec3 eye = camera.position();
  const glm::dvec3 ray = world_from_cam * glm::dvec3((x + 0.5 - camera.cx) / camera.fl_x,
                                                     (y + 0.5 - camera.cy) / camera.fl_y, 1);
  const std::vector<int>& others = neighbours_.at(index);
  std::vector<RaySight> sights;
  for (int i : others) {
    const Frame& other = scene_.frames[size_t(i)];
    sights.push_back({&other.image, &other.mask, &grey_.at(i), &other.camera, i,
                      other.camera.cam_from_world * ray,
                      other.camera.cam_from_world * (eye + (other.time - frame.time) * velocity) +
                          other.camera.translation});
  }
  const double farthest = 1 / (kFarthest * rig_.distance);
  const double range = 1 / (kNearest * rig_.distance) - farthest;
  const Camera& median = scene_.frames[size_t(others[others.size() / 2])].camera;
  const double shift = median.fl_x * glm::distance(median.position(), eye) * range;  // pixels
  const int planes = std::clamp(int(shift / kPixelsAPlane), kFewestPlanes, RaySearch::kMostPlanes);
  const RaySearch search(patch, grey_patch_at(grey_.at(index), x, y), std::move(sights),
                         {farthest, range / (planes - 1), planes});

  const std::optional<int> plane = search.best_plane();
  if (!plane) return std::nullopt;
  const double fine = search.refined(*plane);
  int best = -1;
  const float cost = search.fine(fine, best);
  if (!(cost < std::min(kMostDifference, kMostUnlike * structure))) return std::nullopt;
  const double inverse = search.inverse(fine);
  if (!(inverse > 0)) return std::nullopt;
  return Depth{inverse, best, cost, eye + ray / inverse, velocity};
}

/// Whether the search from the other camera's pixel ends at the same place, as `frame` sees it.
bool PlaneSweep::confirmed(int frame, const Depth& depth) const {
  const auto pixel = [&](const Camera& camera, const glm::dvec3& p) {
    const glm::dvec3 q = camera.cam_from_world * p + camera.translation;
    return glm::dvec2(camera.fl_x * q.x / q.z + camera.cx, camera.fl_y * q.y / q.z + camera.cy);
  };
  const Frame &here = scene_.frames[size_t(frame)], &other = scene_.frames[size_t(depth.best)];
  const double later = other.time - here.time;
  const glm::dvec2 other_pixel = pixel(other.camera, depth.point + later * depth.velocity);
  const std::optional<Depth> back = search({depth.best, int(other_pixel.x), int(other_pixel.y)});
  if (!back) return false;
  return glm::distance(pixel(here.camera, back->point - later * back->velocity),
                       pixel(here.camera, depth.point)) <= kSamePoint;
}

bool PlaneSweep::still(const SweptPixel& pixel) const {
  return still_pixels_->still(scene_.frames[size_t(pixel.frame)], light_.at(pixel.frame), pixel.x,
                              pixel.y);
}

bool PlaneSweep::moves(const SweptPixel& pixel) const {
  const Frame& frame = scene_.frames[size_t(pixel.frame)];
  return has_patch(frame.image, pixel.x, pixel.y) && !still(pixel);
}

std::optional<SweptPoint> PlaneSweep::find(const SweptPixel& pixel) const {
  const std::optional<Depth> depth = search(pixel);
  if (!depth || !confirmed(pixel.frame, *depth)) return std::nullopt;
  const Frame& frame = scene_.frames[size_t(pixel.frame)];
  const uint8_t* rgb =
      frame.image.data.data() + 3 * (size_t(pixel.y) * size_t(frame.image.width) + size_t(pixel.x));
  return SweptPoint{glm::vec3(depth->point),
                    {rgb[0], rgb[1], rgb[2]},
                    float(frame.time),
                    still(pixel),
                    float(1 / (depth->inverse * frame.camera.fl_x)),
                    pixel.frame,
                    glm::vec3(depth->velocity)};
}

std::vector<SweptPoint> PlaneSweep::find(const std::vector<SweptPixel>& pixels) const {
  return all_of<SweptPoint>(int64_t(pixels.size()),
                            [&](int64_t i) { return find(pixels[size_t(i)]); });
}

std::vector<SweptPixel> PlaneSweep::first_of(
    int64_t groups, int64_t each, bool moving,
    const std::function<SweptPixel(int64_t)>& pixel) const {
  return all_of<SweptPixel>(groups, [&](int64_t group) -> std::optional<SweptPixel> {
    for (int64_t i = group * each; i < (group + 1) * each; ++i)
      if (const SweptPixel tried = pixel(i); moves(tried) == moving) return tried;
    return std::nullopt;
  });
}

std::vector<int> PlaneSweep::agreeing_frames(const SweptPoint& point) const {
  std::vector<int> agreeing{point.frame};
  const auto sight_of = [&](int frame) {
    const Frame& seen = scene_.frames[size_t(frame)];
    const Camera& camera = seen.camera;
    return RaySight{&seen.image,
                    &seen.mask,
                    &grey_.at(frame),
                    &camera,
                    frame,
                    camera.translation,
                    camera.cam_from_world *
                        place_at(point, seen.time - scene_.frames[size_t(point.frame)].time)};
  };
  double u, v;
  const RaySight found = sight_of(point.frame);
  if (!found.at(1, u, v)) return agreeing;
  const Patch patch = patch_between(*found.image, u, v);
  const float most = std::min(kMostDifference, kMostUnlike * texture(patch));
  for (int other : neighbours_.at(point.frame)) {
    const RaySight sight = sight_of(other);
    if (!sight.at(1, u, v)) continue;
    const Patch seen = patch_between(*sight.image, u, v);
    if (brightness_difference(patch, seen) <= kMostGain && difference(patch, seen) < most)
      agreeing.push_back(other);
  }
  return agreeing;
}

}  // namespace tessera
