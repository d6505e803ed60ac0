// The search along the ray of a pixel, the check from another camera, and the test for changes over
// time.
#include "ingest/cloud/plane_sweep.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "ingest/clocks/timesteps.h"
#include "kernels/base/parallel.h"

namespace tessera {
namespace {

constexpr double kNearest = 0.25, kFarthest = 4;  // of the distance to the rig's focus
constexpr size_t kNeighbours = 8;                 // cameras that a pixel is compared with
constexpr double kPixelsAPlane = 1.5;             // most that a pixel moves in a median neighbour
constexpr int kFewestPlanes = 48, kMostPlanes = 256;
constexpr int kValley = 3;             // planes on either side of the best that belong to it
constexpr double kFineStep = 0.25;     // of a plane
constexpr float kLeastTexture = 2;     // of a patch, levels
constexpr float kMostDifference = 12;  // of agreeing patches, levels
constexpr float kMostUnlike = 0.7f;    // of agreeing patches, by their texture
constexpr float kMostGain = 48;        // difference of their brightness, levels
constexpr float kDistinct = 1.15f;     // second valley ÷ best
constexpr float kNoAgreement = 1e9f;
constexpr double kSamePoint = 1.5;  // pixels between a point and where the other camera has it

/// A camera along another's ray: pixel position at inverse depth w of that ray, (a + w b) / z.
struct Line {
  const Image8* image;
  const FrameMask* mask;
  const GreyImage* grey;
  const Camera* camera;
  int frame;
  glm::dvec3 a, b;

  /// False behind the camera, outside its image, or where its mask ignores the pixel.
  bool at(double w, double& u, double& v) const {
    const glm::dvec3 p = a + w * b;
    if (p.z <= 0) return false;
    u = camera->fl_x * p.x / p.z + camera->cx;
    v = camera->fl_y * p.y / p.z + camera->cy;
    if (!(u >= 0 && v >= 0 && u < image->width && v < image->height)) return false;
    return has_patch(*image, int(u), int(v)) && !mask->ignores(int(u), int(v));
  }
};

}  // namespace

struct PlaneSweep::Depth {
  double inverse;       // of the depth along the camera's axis
  int best;             // frame that agrees most
  float cost;           // levels
  glm::dvec3 point;     // world units
  glm::dvec3 velocity;  // world units per unit of normalised time
};

struct PlaneSweep::Search {
  Patch patch;
  GreyPatch grey;
  std::vector<Line> lines;
  double farthest, step;  // inverse depth of plane 0, and from one plane to the next
  int planes;

  double inverse(double plane) const { return farthest + step * plane; }

  using Costs = std::array<std::pair<float, int>, kNeighbours>;  // with the frame

  /// Mean over the better half of the other cameras, so that occluded ones have no weight.
  static float better_half(Costs& costs, size_t count) {
    if (count < 2) return kNoAgreement;
    const size_t half = std::max<size_t>(2, (count + 1) / 2);
    std::partial_sort(costs.begin(), costs.begin() + long(half), costs.begin() + long(count));
    float sum = 0;
    for (size_t i = 0; i < half; ++i) sum += costs[i].first;
    return sum / float(half);
  }
  /// In grey, at whole pixels.
  float coarse(double plane) const {
    Costs costs{};
    size_t count = 0;
    double u, v;
    for (const Line& line : lines) {
      if (!line.at(inverse(plane), u, v)) continue;
      const GreyPatch other = grey_patch_at(*line.grey, int(u), int(v));
      if (std::abs(grey.sum - other.sum) > kMostGain * Patch::kPixels) continue;
      costs[count++] = {difference(grey, other), line.frame};
    }
    return better_half(costs, count);
  }
  /// In colour, between pixels; `best` becomes the frame that agrees most.
  float fine(double plane, int& best) const {
    Costs costs{};
    size_t count = 0;
    double u, v;
    for (const Line& line : lines) {
      if (!line.at(inverse(plane), u, v)) continue;
      const Patch other = patch_between(*line.image, u, v);
      if (brightness_difference(patch, other) > kMostGain) continue;
      costs[count++] = {difference(patch, other), line.frame};
    }
    const float cost = better_half(costs, count);
    best = costs[0].second;
    return cost;
  }

  /// The best plane, if no other valley is nearly as deep.
  std::optional<int> best_plane() const {
    std::array<float, kMostPlanes> costs{};
    for (int k = 0; k < planes; ++k) costs[size_t(k)] = coarse(k);
    const int best = int(std::min_element(costs.begin(), costs.begin() + planes) - costs.begin());
    const float least = costs[size_t(best)];
    if (least >= kNoAgreement) return std::nullopt;
    for (int k = 0; k < planes; ++k)
      if (std::abs(k - best) > kValley && costs[size_t(k)] < kDistinct * least) return std::nullopt;
    return best;
  }

  /// Between planes: bilinear patches in fine steps, then the vertex of the parabola through the
  /// best and its neighbours.
  double refined(int plane) const {
    constexpr int kSteps = 4;  // on either side
    std::array<float, size_t(2 * kSteps + 1)> costs;
    int agreeing;
    for (int i = 0; i <= 2 * kSteps; ++i)
      costs[size_t(i)] = fine(plane + kFineStep * (i - kSteps), agreeing);
    const int best = int(std::min_element(costs.begin(), costs.end()) - costs.begin());
    double vertex = 0;
    if (best > 0 && best < 2 * kSteps && costs[size_t(best) - 1] < kNoAgreement &&
        costs[size_t(best) + 1] < kNoAgreement) {
      const double a = costs[size_t(best) - 1], b = costs[size_t(best)],
                   c = costs[size_t(best) + 1];
      if (a - 2 * b + c > 0) vertex = 0.5 * (a - c) / (a - 2 * b + c);
    }
    return plane + kFineStep * (best - kSteps + vertex);
  }
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
    others.resize(std::min(others.size(), kNeighbours));
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

std::optional<PlaneSweep::Depth> PlaneSweep::search(int index, int x, int y) const {
  std::optional<Depth> found = search(index, x, y, glm::dvec3(0));
  const auto velocity = expected_ ? expected_->at(index, x, y) : std::nullopt;
  if (!velocity) return found;
  const std::optional<Depth> moving = search(index, x, y, *velocity);
  return moving && (!found || moving->cost < found->cost) ? moving : found;
}

std::optional<PlaneSweep::Depth> PlaneSweep::search(int index, int x, int y,
                                                    const glm::dvec3& velocity) const {
  const Frame& frame = scene_.frames[size_t(index)];
  if (!has_patch(frame.image, x, y) || frame.mask.ignores(x, y)) return std::nullopt;
  Search search;
  search.patch = patch_at(frame.image, x, y);
  search.grey = grey_patch_at(grey_.at(index), x, y);
  const float structure = texture(search.patch);
  if (structure < kLeastTexture) return std::nullopt;
  const Camera& camera = frame.camera;
  const glm::dmat3 world_from_cam = glm::transpose(camera.cam_from_world);
  const glm::dvec3 eye = camera.position();
  const glm::dvec3 ray = world_from_cam * glm::dvec3((x + 0.5 - camera.cx) / camera.fl_x,
                                                     (y + 0.5 - camera.cy) / camera.fl_y, 1);
  const std::vector<int>& others = neighbours_.at(index);
  for (int i : others) {
    const Frame& other = scene_.frames[size_t(i)];
    search.lines.push_back(
        {&other.image, &other.mask, &grey_.at(i), &other.camera, i,
         other.camera.cam_from_world * ray,
         other.camera.cam_from_world * (eye + (other.time - frame.time) * velocity) +
             other.camera.translation});
  }
  search.farthest = 1 / (kFarthest * rig_.distance);
  const double range = 1 / (kNearest * rig_.distance) - search.farthest;
  const Camera& median = scene_.frames[size_t(others[others.size() / 2])].camera;
  const double shift = median.fl_x * glm::distance(median.position(), eye) * range;  // pixels
  search.planes = std::clamp(int(shift / kPixelsAPlane), kFewestPlanes, kMostPlanes);
  search.step = range / (search.planes - 1);

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
  const std::optional<Depth> back = search(depth.best, int(other_pixel.x), int(other_pixel.y));
  if (!back) return false;
  return glm::distance(pixel(here.camera, back->point - later * back->velocity),
                       pixel(here.camera, depth.point)) <= kSamePoint;
}

bool PlaneSweep::still(int index, int x, int y) const {
  return still_pixels_->still(scene_.frames[size_t(index)], light_.at(index), x, y);
}

bool PlaneSweep::moves(int index, int x, int y) const {
  const Frame& frame = scene_.frames[size_t(index)];
  return has_patch(frame.image, x, y) && !still(index, x, y);
}

std::optional<SweptPoint> PlaneSweep::find(int index, int x, int y) const {
  const std::optional<Depth> depth = search(index, x, y);
  if (!depth || !confirmed(index, *depth)) return std::nullopt;
  const Frame& frame = scene_.frames[size_t(index)];
  const uint8_t* rgb =
      frame.image.data.data() + 3 * (size_t(y) * size_t(frame.image.width) + size_t(x));
  return SweptPoint{glm::vec3(depth->point),
                    {rgb[0], rgb[1], rgb[2]},
                    float(frame.time),
                    still(index, x, y),
                    float(1 / (depth->inverse * frame.camera.fl_x)),
                    index,
                    glm::vec3(depth->velocity)};
}

std::vector<int> PlaneSweep::agreeing_frames(const SweptPoint& point) const {
  std::vector<int> agreeing{point.frame};
  const auto line_of = [&](int frame) {
    const Frame& seen = scene_.frames[size_t(frame)];
    const Camera& camera = seen.camera;
    return Line{&seen.image,
                &seen.mask,
                &grey_.at(frame),
                &camera,
                frame,
                camera.translation,
                camera.cam_from_world *
                    place_at(point, seen.time - scene_.frames[size_t(point.frame)].time)};
  };
  double u, v;
  const Line found = line_of(point.frame);
  if (!found.at(1, u, v)) return agreeing;
  const Patch patch = patch_between(*found.image, u, v);
  const float most = std::min(kMostDifference, kMostUnlike * texture(patch));
  for (int other : neighbours_.at(point.frame)) {
    const Line line = line_of(other);
    if (!line.at(1, u, v)) continue;
    const Patch seen = patch_between(*line.image, u, v);
    if (brightness_difference(patch, seen) <= kMostGain && difference(patch, seen) < most)
      agreeing.push_back(other);
  }
  return agreeing;
}

}  // namespace tessera
