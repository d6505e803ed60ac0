// Builds the pyramids of the frames, chooses start values for the displacement of each point, and
// filters the displacements by those of the neighbours.
#include "ingest/cloud/point_velocities.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <map>
#include <memory>
#include <optional>

#include "ingest/cloud/nearest_few.h"
#include "ingest/cloud/point_motion.h"
#include "kernels/base/median.h"
#include "kernels/base/parallel.h"

namespace tessera {
namespace {

constexpr int kNeighbours = 12;         // points whose displacements are tried
constexpr int kRounds = 2;              // in which they are
constexpr int kStarts = 4;              // of them, at most, in a round
constexpr double kReach = 3;            // of neighbours, by the median distance of the farthest
constexpr int kFewestViews = 3;         // that agree on a reliable displacement
constexpr double kMostUncertain = 0.5;  // pixels, of a reliable displacement
constexpr double kNoise = 1;            // of images, levels
constexpr double kDrop = 0.8;           // most of the difference that motion leaves
constexpr double kAtRest = 0.5;         // pixels: too little to see a drop
constexpr double kAlikeByLength = 0.3;  // most that displacements of neighbours differ by,
constexpr double kAlike = 0.75;         // and pixels on top
constexpr double kFar = 3;  // spacings: displacements that neighbours must not contradict
constexpr size_t kSpacingNeighbour = 3;  // whose distance is a point's spacing
constexpr double kFewestAlike = 0.25;    // of the neighbours, by which they do not
constexpr size_t kFewestLenders = 3;     // neighbours with a reliable displacement,
constexpr double kLendersAlike = 0.5;    // and those of them that agree, for a point without
constexpr int64_t kGrain = 16;           // points

struct Estimate {
  glm::dvec3 displacement{0.0};  // in a timestep, world units
  MotionScore score;
  bool reliable = false;
};

/// The frames of a key timestep with what lies beside them in time.
class Views {
 public:
  Views(const PlaneSweep& sweep, const std::vector<const Scene*>& around,
        const std::vector<SweptPoint*>& points);

  /// Normalised time from a timestep to the next.
  double timestep() const { return timestep_; }
  /// The size of a pixel at the point of this number, world units.
  double pixel(size_t i) const { return points_[i]->pixel; }
  /// Of the point of this number.
  PointMotion motion(size_t i) const;

 private:
  void add_others(const Frame& key, const std::vector<const Scene*>& around, MotionView& view);

  const PlaneSweep& sweep_;
  const std::vector<SweptPoint*>& points_;
  std::vector<std::vector<int>> agreeing_;                       // frames, of each point
  std::map<int, MotionView> view_;                               // by frame of the sweep
  std::map<const Frame*, std::unique_ptr<GreyPyramid>> images_;  // of all of them
  double timestep_ = 1;
};

/// The nearest frames of the camera before and after, with their distance in time for now.
void Views::add_others(const Frame& key, const std::vector<const Scene*>& around,
                       MotionView& view) {
  const Frame *before = nullptr, *after = nullptr;
  const auto consider = [&](const Frame& frame) {
    if (frame.split != Split::kTrain || frame.camera_name != key.camera_name) return;
    if (frame.time < key.time && (before == nullptr || frame.time > before->time)) before = &frame;
    if (frame.time > key.time && (after == nullptr || frame.time < after->time)) after = &frame;
  };
  for (const Scene* scene : around)
    for (const Frame& frame : scene->frames) consider(frame);
  for (const Frame* frame : {before, after})
    if (frame != nullptr) view.others.push_back({frame, nullptr, frame->time - key.time});
}

Views::Views(const PlaneSweep& sweep, const std::vector<const Scene*>& around,
             const std::vector<SweptPoint*>& points)
    : sweep_(sweep), points_(points), agreeing_(points.size()) {
  parallel_for(int64_t(points.size()), kGrain, [&](int64_t begin, int64_t end) {
    for (auto i = size_t(begin); i < size_t(end); ++i)
      agreeing_[i] = sweep.agreeing_frames(*points[i]);
  });
  std::vector<double> steps;
  for (const std::vector<int>& agreeing : agreeing_)
    for (const int index : agreeing) {
      const Frame& key = sweep.scene().frames[size_t(index)];
      const auto [at, is_new] = view_.try_emplace(index, MotionView{&key, nullptr, {}});
      if (!is_new) continue;
      add_others(key, around, at->second);
      images_.emplace(&key, nullptr);
      for (const MotionView::Other& other : at->second.others) {
        images_.emplace(other.frame, nullptr);
        steps.push_back(std::abs(other.steps));
      }
    }
  std::vector<std::pair<const Frame* const, std::unique_ptr<GreyPyramid>>*> missing;
  for (auto& entry : images_) missing.push_back(&entry);
  parallel_for(int64_t(missing.size()), 1, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) {
      auto& [frame, pyramid] = *missing[size_t(i)];
      pyramid = std::make_unique<GreyPyramid>(grey_pyramid(frame->image));
    }
  });
  if (!steps.empty()) timestep_ = median(steps);
  for (auto& [index, view] : view_) {
    view.image = images_.at(view.key).get();
    for (MotionView::Other& other : view.others) {
      other.image = images_.at(other.frame).get();
      other.steps /= timestep_;
    }
  }
}

PointMotion Views::motion(size_t i) const {
  const SweptPoint& point = *points_[i];
  std::vector<MotionView> views;
  const double time = sweep_.scene().frames[size_t(point.frame)].time;
  for (const int index : agreeing_[i]) {
    views.push_back(view_.at(index));
    views.back().offset =
        place_at(point, views.back().key->time - time) - glm::dvec3(point.position);
  }
  return {glm::dvec3(point.position), double(point.pixel), std::move(views)};
}

/// The score of a displacement by the images alone.
bool is_reliable(const MotionScore& score, const MotionScore& at_rest, double pixels) {
  const double error = (score.difference + kNoise) / kMostUncertain;
  return score.agreeing >= kFewestViews && score.information >= error * error &&
         (pixels < kAtRest || score.difference <= kDrop * at_rest.difference);
}

/// The search of one point over given starts, pixels at the point.
class Search {
 public:
  Search(const Views& views, size_t i) : pixel_(views.pixel(i)), motion_(views.motion(i)) {}

  void from(const glm::dvec3& displacement, int coarsest, Estimate& best) const {
    const glm::dvec3 found = motion_.refined(displacement / pixel_, coarsest);
    const MotionScore score = motion_.score(found);
    if (score.difference < best.score.difference) best = {found * pixel_, score, false};
  }
  double difference(const glm::dvec3& displacement) const {
    return motion_.score(displacement / pixel_).difference;
  }
  MotionScore at_rest() const { return motion_.score(glm::dvec3(0)); }
  void judge(Estimate& estimate) const {
    estimate.reliable =
        is_reliable(estimate.score, at_rest(), glm::length(estimate.displacement) / pixel_);
  }

 private:
  double pixel_;
  PointMotion motion_;
};

Estimate from_rest(const Views& views, size_t i) {
  const Search search(views, i);
  Estimate best{glm::dvec3(0), search.at_rest(), false};
  for (int coarsest : {kPyramidLevels - 1, 1}) search.from(glm::dvec3(0), coarsest, best);
  search.judge(best);
  return best;
}

/// The best of `before` and what is reached from the likeliest of the neighbours' displacements.
Estimate from_neighbours(const Views& views, size_t i, const Estimate& before,
                         const std::vector<glm::dvec3>& displacements) {
  if (displacements.empty()) return before;
  const Search search(views, i);
  std::vector<std::pair<double, size_t>> starts;
  for (size_t k = 0; k < displacements.size(); ++k)
    starts.emplace_back(search.difference(displacements[k]), k);
  std::sort(starts.begin(), starts.end());
  Estimate best = before;
  search.from(displacements[starts[0].second], 1, best);
  search.judge(best);
  return best;
}

bool alike(const glm::dvec3& a, const glm::dvec3& b, double pixel) {
  return glm::distance(a, b) <= kAlikeByLength * glm::length(a) + kAlike * pixel;
}

glm::dvec3 median_of(const std::vector<glm::dvec3>& displacements) {
  glm::dvec3 result;
  for (glm::length_t axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const glm::dvec3& displacement : displacements) values.push_back(displacement[axis]);
    result[axis] = median(values);
  }
  return result;
}

/// The points of a timestep, their neighbours and what was found of them.
class Motions {
 public:
  Motions(const Views& views, const std::vector<SweptPoint*>& points);

  void search_from_rest();
  void search_from_neighbours();
  /// Displacement of point i as its neighbours leave it. Where its own is not reliable, that which
  /// they agree on, if the images agree with it better than with rest.
  std::optional<glm::dvec3> agreed(size_t i) const;

 private:
  /// Reliable displacements of neighbours, nearest first.
  std::vector<glm::dvec3> reliable_around(size_t i) const;
  std::optional<glm::dvec3> lent(size_t i, const std::vector<glm::dvec3>& around) const;
  double spacing(size_t i) const;  // world units
  void for_all(const std::function<Estimate(size_t)>& estimate);

  const Views& views_;
  const std::vector<SweptPoint*>& points_;
  std::vector<std::vector<Neighbour>> neighbours_;
  double reach_ = 0;  // world units
  std::vector<Estimate> estimates_;
};

Motions::Motions(const Views& views, const std::vector<SweptPoint*>& points)
    : views_(views), points_(points), estimates_(points.size()) {
  std::vector<glm::vec3> positions;
  for (const SweptPoint* point : points) positions.push_back(point->position);
  neighbours_ = nearest_few(positions, kNeighbours);
  std::vector<double> farthest;
  for (const std::vector<Neighbour>& near : neighbours_)
    if (!near.empty()) farthest.push_back(near.back().distance);
  if (!farthest.empty()) reach_ = kReach * median(farthest);
}

void Motions::for_all(const std::function<Estimate(size_t)>& estimate) {
  std::vector<Estimate> made(points_.size());
  parallel_for(int64_t(points_.size()), kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) made[size_t(i)] = estimate(size_t(i));
  });
  estimates_ = std::move(made);
}

std::vector<glm::dvec3> Motions::reliable_around(size_t i) const {
  std::vector<glm::dvec3> found;
  for (const Neighbour& near : neighbours_[i]) {
    const Estimate& other = estimates_[size_t(near.index)];
    if (near.distance <= reach_ && other.reliable) found.push_back(other.displacement);
  }
  return found;
}

void Motions::search_from_rest() {
  for_all([&](size_t i) { return from_rest(views_, i); });
}

void Motions::search_from_neighbours() {
  for_all([&](size_t i) {
    std::vector<glm::dvec3> starts = reliable_around(i);
    starts.resize(std::min(starts.size(), size_t(kStarts)));
    if (starts.size() > 1) starts.push_back(median_of(starts));
    return from_neighbours(views_, i, estimates_[i], starts);
  });
}

double Motions::spacing(size_t i) const {
  const std::vector<Neighbour>& near = neighbours_[i];
  return near.empty() ? 0 : near[std::min(near.size(), kSpacingNeighbour) - 1].distance;
}

std::optional<glm::dvec3> Motions::lent(size_t i, const std::vector<glm::dvec3>& around) const {
  if (around.size() < kFewestLenders) return std::nullopt;
  const glm::dvec3 displacement = median_of(around);
  const auto same = std::count_if(around.begin(), around.end(), [&](const glm::dvec3& other) {
    return alike(displacement, other, points_[i]->pixel);
  });
  if (double(same) < kLendersAlike * double(around.size())) return std::nullopt;
  const Search search(views_, i);
  if (search.difference(displacement) >= search.at_rest().difference) return std::nullopt;
  return displacement;
}

std::optional<glm::dvec3> Motions::agreed(size_t i) const {
  const Estimate& estimate = estimates_[i];
  const std::vector<glm::dvec3> around = reliable_around(i);
  if (!estimate.reliable) return lent(i, around);
  std::vector<glm::dvec3> same{estimate.displacement};
  for (const glm::dvec3& other : around)
    if (alike(estimate.displacement, other, points_[i]->pixel)) same.push_back(other);
  const bool contradicted = double(same.size() - 1) < kFewestAlike * double(around.size());
  if (contradicted && glm::length(estimate.displacement) > kFar * spacing(i)) return std::nullopt;
  return median_of(same);
}

}  // namespace

VelocityCount find_velocities(const PlaneSweep& sweep, const std::vector<const Scene*>& around,
                              const std::vector<SweptPoint*>& points) {
  std::vector<SweptPoint*> moving;
  for (SweptPoint* point : points)
    if (!point->still) moving.push_back(point);
  VelocityCount count{int64_t(moving.size()), 0};
  if (moving.empty()) return count;
  const Views views(sweep, around, moving);
  Motions motions(views, moving);
  motions.search_from_rest();
  for (int round = 0; round < kRounds; ++round) motions.search_from_neighbours();
  for (size_t i = 0; i < moving.size(); ++i) {
    const auto displacement = motions.agreed(i);
    moving[i]->velocity = glm::vec3(displacement.value_or(glm::dvec3(0)) / views.timestep());
    count.reliable += displacement.has_value();
  }
  return count;
}

}  // namespace tessera
