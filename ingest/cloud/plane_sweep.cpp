// The cameras that a pixel is compared with, the check from another camera, and the test for
// changes over time.
#include "ingest/cloud/plane_sweep.h"

#include <algorithm>
#include <glm/geometric.hpp>

#include "ingest/clocks/timesteps.h"
#include "ingest/cloud/ray_search.h"
#include "kernels/base/camera_rig.h"
#include "kernels/base/parallel.h"

namespace tessera {
namespace {

constexpr double kNearest = 0.25, kFarthest = 4;  // of the distance to the rig's focus
constexpr double kSamePoint = 1.5;  // pixels between a point and where the other camera has it
constexpr int64_t kGrainPixels = 16;

DepthRange depth_range(const Scene& scene) {
  const double distance = make_camera_rig(scene.training_cameras()).distance;
  const double farthest = 1 / (kFarthest * distance);
  return {farthest, 1 / (kNearest * distance) - farthest};
}

/// Begins to bring the pixels of a patch to the cache.
void fetch_patch(const RgbView& image, int x, int y) {
  for (int dy = -Patch::kRadius; dy <= Patch::kRadius; ++dy)
    __builtin_prefetch(image.at(x - Patch::kRadius, y + dy));
}

/// make(i), as far as there is one, in the order of i below `count`.
template <class Value>
std::vector<Value> all_of(int64_t count, const std::function<std::optional<Value>(int64_t)>& make) {
  std::vector<std::optional<Value>> made(static_cast<size_t>(count));
  parallel_for(count, kGrainPixels, [&](int64_t begin, int64_t end) {
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

void set_frame(const Frame& frame, const StillPixels& still_pixels, SearchView& view) {
  view.image = rgb_of(frame.image);
  view.mask = frame.mask.data().empty() ? nullptr : frame.mask.data().data();
  view.camera = frame.camera;
  view.eye = frame.camera.position();
  view.time = frame.time;
  for (const StillSight& sight : still_pixels.sights_of(frame, still_pixels.light_of(frame)))
    view.sights[view.sight_count++] = sight;
}

PlaneSweep::PlaneSweep(const Scene& scene)
    : PlaneSweep(scene, std::make_shared<const StillPixels>(scene)) {}

PlaneSweep::PlaneSweep(const Scene& scene, std::shared_ptr<const StillPixels> still_pixels,
                       PixelSearch* device)
    : scene_(scene), range_(depth_range(scene)), views_(scene.frames.size()), device_(device) {
  for (const Timestep& timestep : training_timesteps(scene))
    if (timestep.frames.size() >= 3) choose_neighbours(timestep.frames);
  for (const int frame : usable_) grey_[frame] = {};
  parallel_for(int64_t(usable_.size()), 1, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) {
      const int index = usable_[size_t(i)];
      const Frame& frame = scene.frames[size_t(index)];
      SearchView& view = views_[size_t(index)];
      if (device_ == nullptr) grey_.at(index) = grey_image(frame.image);
      view.grey = grey_.at(index).level.data();
      set_frame(frame, *still_pixels, view);
    }
  });
  if (device_ != nullptr) device_->set_views(views_, range_);
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
    others.resize(std::min(others.size(), size_t(kMostSights)));
    SearchView& view = views_[size_t(frame)];
    for (const auto& [distance, other] : others) view.others[view.other_count++] = other;
    usable_.push_back(frame);
  }
}

bool PlaneSweep::expect_motion_of(const std::vector<SweptPoint>& points) {
  ExpectedMotion expected(scene_, usable_, points);
  if (expected.largest_shift() <= kLeastShift) return false;
  expected_ = std::move(expected);
  return true;
}

std::vector<RayDepth> PlaneSweep::depths(const std::vector<RayQuery>& queries) const {
  if (device_ != nullptr) return device_->depths(queries);
  std::vector<RayDepth> found(queries.size());
  parallel_for(int64_t(queries.size()), kGrainPixels, [&](int64_t begin, int64_t end) {
    for (auto i = size_t(begin); i < size_t(end); ++i)
      found[i] = ray_depth(views_, range_, queries[i]);
  });
  return found;
}

/// As something at rest and, where a motion is expected, as something that moves so: what the
/// cameras agree on more.
std::vector<std::optional<PlaneSweep::Depth>> PlaneSweep::search(
    const std::vector<ViewPixel>& pixels) const {
  std::vector<RayQuery> queries;
  std::vector<size_t> of;  // the pixel of each
  const auto add = [&](size_t i, const glm::dvec3& velocity) {
    of.push_back(i);
    queries.push_back({pixels[i], velocity});
  };
  for (size_t i = 0; i < pixels.size(); ++i) add(i, glm::dvec3(0));
  for (size_t i = 0; expected_ && i < pixels.size(); ++i)
    if (const auto velocity = expected_->at(pixels[i].view, pixels[i].x, pixels[i].y))
      add(i, *velocity);
  const std::vector<RayDepth> found = depths(queries);
  std::vector<std::optional<Depth>> best(pixels.size());
  for (size_t k = 0; k < queries.size(); ++k) {
    const RayDepth& depth = found[k];
    std::optional<Depth>& kept = best[of[k]];
    if (depth.inverse == 0 || (kept && kept->cost <= depth.cost)) continue;
    const RayQuery& query = queries[k];
    const SearchView& view = views_[size_t(query.pixel.view)];
    kept = Depth{depth.inverse, depth.best, depth.cost,
                 view.eye + ray_of(view, query.pixel.x, query.pixel.y) / depth.inverse,
                 query.velocity};
  }
  return best;
}

glm::dvec2 PlaneSweep::pixel_of(const glm::dvec3& point, int frame) const {
  const Camera& camera = scene_.frames[size_t(frame)].camera;
  const glm::dvec3 q = camera.cam_from_world * point + camera.translation;
  return {camera.fl_x * q.x / q.z + camera.cx, camera.fl_y * q.y / q.z + camera.cy};
}

bool PlaneSweep::still(const ViewPixel& pixel) const {
  const SearchView& view = views_[size_t(pixel.view)];
  // frames lie far apart in memory: all patches are on their way before the first is compared
  for (int i = 0; i < view.sight_count; ++i) fetch_patch(view.sights[i].image, pixel.x, pixel.y);
  return is_still(view.image, pixel.x, pixel.y, view.sights, view.sight_count);
}

bool PlaneSweep::moves(const ViewPixel& pixel) const {
  return has_patch(views_[size_t(pixel.view)].image, pixel.x, pixel.y) && !still(pixel);
}

std::vector<SweptPoint> PlaneSweep::find(const std::vector<ViewPixel>& pixels) const {
  const std::vector<std::optional<Depth>> depths = search(pixels);
  // the search from the other camera's pixel must end at the same place, as the frame sees it
  std::vector<ViewPixel> others;
  std::vector<size_t> of;  // the pixel of each
  const auto later = [&](size_t i) {
    return scene_.frames[size_t(depths[i]->best)].time - scene_.frames[size_t(pixels[i].view)].time;
  };
  for (size_t i = 0; i < pixels.size(); ++i) {
    const std::optional<Depth>& depth = depths[i];
    if (!depth) continue;
    const glm::dvec2 seen = pixel_of(depth->point + later(i) * depth->velocity, depth->best);
    of.push_back(i);
    others.push_back({depth->best, int(seen.x), int(seen.y)});
  }
  const std::vector<std::optional<Depth>> back = search(others);
  return all_of<SweptPoint>(int64_t(of.size()), [&](int64_t k) -> std::optional<SweptPoint> {
    const size_t i = of[size_t(k)];
    const auto& [index, x, y] = pixels[i];
    const Depth& depth = *depths[i];
    const std::optional<Depth>& other = back[size_t(k)];
    if (!other || glm::distance(pixel_of(other->point - later(i) * other->velocity, index),
                                pixel_of(depth.point, index)) > kSamePoint)
      return std::nullopt;
    const Frame& frame = scene_.frames[size_t(index)];
    const uint8_t* rgb = rgb_of(frame.image).at(x, y);
    return SweptPoint{glm::vec3(depth.point),
                      {rgb[0], rgb[1], rgb[2]},
                      float(frame.time),
                      still(pixels[i]),
                      float(1 / (depth.inverse * frame.camera.fl_x)),
                      index,
                      glm::vec3(depth.velocity)};
  });
}

std::vector<ViewPixel> PlaneSweep::first_of(int64_t groups, int64_t each, bool moving,
                                            const std::function<ViewPixel(int64_t)>& pixel) const {
  std::vector<ViewPixel> tried;  // all of them on a device, else one at a time
  std::vector<uint8_t> moved;
  if (device_ != nullptr) {
    tried.resize(size_t(groups * each));
    parallel_for(int64_t(tried.size()), 1024, [&](int64_t begin, int64_t end) {
      for (int64_t i = begin; i < end; ++i) tried[size_t(i)] = pixel(i);
    });
    moved = device_->moves(tried);
  }
  return all_of<ViewPixel>(groups, [&](int64_t group) -> std::optional<ViewPixel> {
    for (int64_t i = group * each; i < (group + 1) * each; ++i) {
      const ViewPixel here = tried.empty() ? pixel(i) : tried[size_t(i)];
      if ((moved.empty() ? moves(here) : moved[size_t(i)] != 0) == moving) return here;
    }
    return std::nullopt;
  });
}

std::vector<int> PlaneSweep::agreeing_frames(const SweptPoint& point) const {
  std::vector<int> agreeing{point.frame};
  const auto sight_at = [&](int frame) {
    const Camera& camera = scene_.frames[size_t(frame)].camera;
    const double later =
        scene_.frames[size_t(frame)].time - scene_.frames[size_t(point.frame)].time;
    return RaySight{&views_[size_t(frame)], frame, camera.translation,
                    camera.cam_from_world * place_at(point, later)};
  };
  double u, v;
  const RaySight found = sight_at(point.frame);
  if (!found.at(1, u, v)) return agreeing;
  const SearchView& view = *found.view;
  const Patch patch = patch_between(view.image, u, v);
  const float most = most_cost(texture(patch));
  for (int i = 0; i < view.other_count; ++i)
    if (fine_cost(patch, sight_at(view.others[i]), 1) < most) agreeing.push_back(view.others[i]);
  return agreeing;
}

}  // namespace tessera
