// The choice of validation frames, the record of scores, and the best model so far.
#include "recon4d/training/validation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "kernels/base/errors.h"
#include "kernels/math/random.h"
#include "recon4d/density/density.h"
#include "recon4d/evaluation/evaluate.h"
#include "recon4d/training/schedule.h"

namespace tessera {
namespace {

/// A training frame by its camera and its place in that camera's sequence.
struct Place {
  int frame;
  int64_t camera, moment;
  bool at_end;  // first or last of a sequence
};

std::vector<Place> training_places(const Scene& scene) {
  std::map<std::string, std::vector<int>> cameras;
  for (int i : scene.split_indices(Split::kTrain))
    cameras[scene.frames[size_t(i)].camera_name].push_back(i);
  std::vector<Place> places;
  int64_t camera = 0;
  for (auto& [name, frames] : cameras) {
    std::stable_sort(frames.begin(), frames.end(), [&](int a, int b) {
      return scene.frames[size_t(a)].time < scene.frames[size_t(b)].time;
    });
    for (size_t m = 0; m < frames.size(); ++m)
      places.push_back(
          {frames[m], camera, int64_t(m), frames.size() > 1 && (m == 0 || m + 1 == frames.size())});
    ++camera;
  }
  return places;
}

double fraction(double value) {
  return value - std::floor(value);
}

}  // namespace

int64_t hold_out_validation(Scene& scene, double share, uint64_t seed) {
  if (share <= 0) return 0;
  std::vector<Place> places = training_places(scene);
  const auto count = int64_t(places.size());
  if (count < 2)
    throw InputError(
        fmt::format("{}: {} training frame, and validation_share needs two; pass "
                    "--validation-share 0",
                    scene.path, count));
  const int64_t wanted = std::clamp<int64_t>(std::llround(share * double(count)), 1, count - 1);
  const double shift = uniform(philox(seed, RandomStream::kValidationSplit, 0).word[0]);
  // A lattice: among the frames of a camera, and among those of a timestep, the smallest values are
  // evenly spread. A model is not judged by what it must extrapolate to: ends come last.
  const auto key = [&](const Place& place) {
    constexpr double kGolden = 0.6180339887498949, kSilver = 0.4142135623730951;
    return double(place.at_end) +
           fraction(shift + kGolden * double(place.moment) + kSilver * double(place.camera));
  };
  std::stable_sort(places.begin(), places.end(),
                   [&](const Place& a, const Place& b) { return key(a) < key(b); });
  for (int64_t i = 0; i < wanted; ++i)
    scene.frames[size_t(places[size_t(i)].frame)].split = Split::kValidation;
  return wanted;
}

Validation::Validation(Backend& backend, const Scene& scene, const TrainOptions& options,
                       ValidationRecord record)
    : backend_(backend),
      scene_(scene),
      frames_(int64_t(scene.split_indices(Split::kValidation).size())),
      interval_(std::max<int64_t>(1, scaled_steps(options, options.validate_interval))),
      iterations_(options.iterations),
      patience_(options.stop_patience),
      batch_(options.batch),
      within_db_(options.within_db),
      record_(record) {}

int64_t Validation::next_after(int64_t iteration) const {
  const int64_t next = (iteration / interval_ + 1) * interval_;
  return iteration < iterations_ ? std::min(next, iterations_) : next;
}

bool Validation::due(int64_t iteration) const {
  return on() && iteration > record_.last_iteration && next_after(iteration - 1) == iteration;
}

double Validation::psnr(const GaussianModel& model) const {
  tessera::check(on(), "Validation: there are no validation frames");
  EvaluateOptions options;
  options.batch = int(batch_);
  options.structure = StructureDetail::kNone;
  options.pixel_sums = false;
  return evaluate(backend_, model, scene_, Split::kValidation, options).all.psnr.value();
}

void Validation::check(const GaussianModel& model, int64_t iteration, double seconds) {
  if (record_.add(iteration, seconds, psnr(model), model.count(), patience_, within_db_))
    best_ = model.clone_values();
}

GaussianModel Validation::shipped() const {
  tessera::check(best_.has_value(), "Validation: no model is known to be the best");
  GaussianModel model = best_->clone_values();
  const std::unique_ptr<Backend> host = make_cpu_backend();
  for (GaussianSet* set : {&model.static_set, &model.dynamic_set}) {
    SetStatistics statistics;
    statistics.reset(set->count());
    prune_invisible(*host, *set, statistics);
  }
  return model;
}

}  // namespace tessera
