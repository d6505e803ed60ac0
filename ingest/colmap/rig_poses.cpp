// Estimates one pose for each camera of a static rig with COLMAP, on images without moving objects.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ingest/colmap/colmap_model.h"
#include "ingest/colmap/colmap_workspace.h"
#include "ingest/colmap/pose_cache.h"
#include "ingest/colmap/pose_estimation.h"
#include "ingest/files/atomic_file.h"
#include "ingest/images/image_paths.h"
#include "ingest/test_views.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

constexpr int kRounds = 2;  // of triangulation and adjustment: the third changes < 0.001 degrees

/// What helps where cameras have no or few points in common.
std::string overlap_remedy(const std::vector<StillImage>& stills) {
  constexpr int kSmall = 480;  // pixels of the longer side
  const auto side = [](const StillImage& still) {
    return std::max(still.image.width, still.image.height);
  };
  const StillImage& largest = *std::max_element(
      stills.begin(), stills.end(),
      [&](const StillImage& a, const StillImage& b) { return side(a) < side(b); });
  return fmt::format(
      "{}let neighbouring cameras see more of the same textured things, or pass --poses FILE",
      side(largest) >= kSmall ? ""
                              : fmt::format("images of {}x{} hold few features: use larger ones, ",
                                            largest.image.width, largest.image.height));
}

/// COLMAP's models of the lens: that the mapper estimates, and the one that is enough where there
/// is no distortion; the latter is empty where the user chose the model.
struct RigLens {
  std::string mapped, plain;
};

RigLens rig_lens(const std::vector<RigClip>& clips, const PoseOptions& options) {
  if (!options.lens_model.empty()) return {options.lens_model, ""};
  const bool square = std::all_of(clips.begin(), clips.end(), [](const RigClip& clip) {
    return clip.timeline.has_square_pixels();
  });
  if (square) return {"SIMPLE_RADIAL", "SIMPLE_PINHOLE"};
  return {"OPENCV", "PINHOLE"};  // with two focal lengths
}

struct RigSolver {
  const ColmapWorkspace& work;
  const ColmapProgram& colmap;
  const PoseOptions& options;
  RigLens lens;
  std::string remedy;                // where cameras have no points in common
  std::vector<std::string> names;    // of the images, one a clip
  std::vector<std::string> cameras;  // of the clips
  double max_error = 1;              // pixels, of the last rounds

  /// The poses are in `chosen` afterwards; returns the mapper's model they came of, an empty path
  /// where there is none. Nothing is run where `key` is that of what is there.
  std::filesystem::path solve(const std::vector<StillImage>& stills, const std::string& key,
                              std::vector<std::string>& warnings) const;
  /// Points and colours of the training cameras alone, into work.folder/points/model; none where
  /// these have no points in common.
  void triangulate_training(const std::vector<char>& held_out, const std::string& key) const;
  std::filesystem::path chosen() const { return work.folder / "refined" / "chosen"; }
  size_t clip_of(const std::string& name) const;

 private:
  void map() const;
  std::optional<ColmapModel> refine(const ColmapModel& start, const std::string& lens_model) const;
  void choose_refined(const ColmapModel& mapped) const;
};

size_t RigSolver::clip_of(const std::string& name) const {
  const auto found = std::find(names.begin(), names.end(), name);
  check(found != names.end(), "COLMAP names an image that it was not given");
  return size_t(found - names.begin());
}

/// Registers cameras one after the other; models into work.sparse.
void RigSolver::map() const {
  make_folder(work.sparse);
  try {
    colmap.run("mapper",
               {{"--database_path", work.database.string()},
                {"--image_path", work.images.string()},
                {"--output_path", work.sparse.string()},
                {"--Mapper.min_model_size", "3"},
                {"--Mapper.ba_refine_principal_point", "0"}},
               "colmap: registering cameras", "Registering image", int64_t(names.size()), remedy);
  } catch (const ColmapFailure& failure) {
    failure.rethrow(cameras, remedy);
  }
}

std::vector<PosedImage> posed_images(const ColmapModel& model) {
  std::vector<PosedImage> images;
  for (const ColmapPhoto& photo : model.photos)
    images.push_back({photo.name, {photo.name, photo.camera, photo.lens, photo.lens_model}});
  return images;
}

/// Tracks are made anew from exact matches and everything is adjusted, twice: the mapper's own
/// tracks hold features that are off by up to 4 pixels. Nothing where no exact match is left.
std::optional<ColmapModel> RigSolver::refine(const ColmapModel& start,
                                             const std::string& lens_model) const {
  auto images = posed_images(start);
  if (!lens_model.empty())
    for (PosedImage& image : images) {
      image.camera.lens_model = lens_model;
      image.camera.lens = {};
    }
  const auto folder = work.folder / "refined" / (lens_model.empty() ? "as mapped" : lens_model);
  auto model = folder / "start";
  write_posed_model(model, images);
  return with_points([&] {
    for (int round = 0; round < kRounds; ++round) {
      const auto points = folder / fmt::format("points{}", round);
      const auto adjusted = folder / fmt::format("adjusted{}", round);
      make_folder(adjusted);
      work.triangulate(colmap, model, points, max_error);
      colmap.run("bundle_adjuster",
                 {{"--input_path", points.string()},
                  {"--output_path", adjusted.string()},
                  {"--BundleAdjustment.refine_principal_point", "0"},
                  {"--BundleAdjustment.max_num_iterations", "200"}},
                 "colmap: adjusting cameras");
      model = adjusted;
    }
    return read_colmap_model(model);
  });
}

/// Whether distortion explains more than chance would let it: √n is what counts of n points scatter
/// by. Distortion that is not there costs accuracy.
bool needs_lens(const ColmapModel& with, const ColmapModel& without) {
  const auto points = double(without.points.position.size());
  return double(with.points.position.size()) > points + std::sqrt(points);
}

/// The result, as a text model in work.folder/refined/chosen. Where no lens was asked for, there is
/// one only if the images need it. Where a lens fits so badly that half of the points go, or all of
/// them, the mapper's result stays.
void RigSolver::choose_refined(const ColmapModel& mapped) const {
  std::optional<ColmapModel> best = refine(mapped, "");
  if (!lens.plain.empty()) {
    std::optional<ColmapModel> plain = refine(mapped, lens.plain);
    if (plain && (!best || !needs_lens(*best, *plain))) best = std::move(plain);
  }
  const bool fits = best && best->photos.size() == mapped.photos.size() &&
                    2 * best->points.position.size() >= mapped.points.position.size();
  write_posed_model(chosen(), posed_images(fits ? *best : mapped));
}

std::filesystem::path RigSolver::solve(const std::vector<StillImage>& stills,
                                       const std::string& key,
                                       std::vector<std::string>& warnings) const {
  const bool is_known = work.holds(key);
  if (!is_known) {
    work.clear();
    for (size_t i = 0; i < stills.size(); ++i) work.add(i, stills[i]);
    work.find_matches(colmap, {lens.mapped, options.intrinsics_per_camera()}, stills.size());
    map();
  }
  const auto largest = largest_colmap_model(work.sparse, stills.size(), warnings);
  if (is_known || largest.empty()) return largest;
  choose_refined(read_colmap_model(largest));
  work.store_key(key);
  return largest;
}

/// Writes the still images and adds them to the key.
std::vector<StillImage> still_images(const std::vector<RigClip>& clips, Fnv1a& key,
                                     const IngestProgress& progress) {
  std::vector<StillImage> stills;
  for (const RigClip& clip : clips) {
    progress("reading frames for the camera poses", int64_t(stills.size()), int64_t(clips.size()));
    stills.push_back(
        still_image(sample_images(clip, spread_frames(clip.timeline.ticks.size(), kStillSamples))));
    const Image8& image = stills.back().image;
    key.add(fmt::format("{} {}x{}", clip.name, image.width, image.height));
    key.add(image.data.data(), image.data.size());
    key.add(stills.back().mask.data.data(), stills.back().mask.data.size());
  }
  return stills;
}

void name_unregistered(const std::vector<RigClip>& clips, const PoseOptions& options,
                       const RigSolver& solver, PoseEstimate& estimate) {
  std::vector<std::string> missing;
  for (size_t i = 0; i < clips.size(); ++i)
    if (!estimate.cameras[i]) missing.push_back(clips[i].name);
  if (clips.size() - missing.size() < 2)
    throw InputError(fmt::format(
        "COLMAP registered {} of {} cameras, expected at least 2; {}; its log: {}",
        clips.size() - missing.size(), clips.size(), solver.remedy, solver.colmap.log().string()));
  if (missing.empty()) return;
  const std::string seen =
      fmt::format("COLMAP registered {} of {} cameras, not {}", clips.size() - missing.size(),
                  clips.size(), fmt::join(missing, ", "));
  if (options.strict)
    throw InputError(fmt::format("{}; {}, or leave --strict out to prepare the others; its log: {}",
                                 seen, solver.remedy, solver.colmap.log().string()));
  estimate.warnings.push_back(seen + "; the scene is made without");
}

void RigSolver::triangulate_training(const std::vector<char>& held_out,
                                     const std::string& key) const {
  const ColmapWorkspace points(work.folder / "points");
  if (points.holds(key)) return;
  std::filesystem::remove_all(points.folder);
  std::vector<PosedImage> training;
  for (PosedImage& image : posed_images(read_colmap_model(chosen())))
    if (!held_out[clip_of(image.name)]) training.push_back(std::move(image));
  write_posed_model(points.folder / "posed", training);
  const auto model = points.folder / "model";
  const bool has_points = training.size() > 1 && with_points([&] {
                            work.triangulate(colmap, points.folder / "posed", model, 2 * max_error);
                            return read_colmap_model(model);  // its files may be incomplete
                          });
  if (!has_points) std::filesystem::remove_all(model);
  points.store_key(key);
}

/// Whether `work` has the poses of `key` and either the points of `split` or what makes them: a
/// result of the cache has no database.
bool is_known(const ColmapWorkspace& work, const std::string& key, const std::string& split) {
  return work.holds(key) && (std::filesystem::exists(work.database) ||
                             ColmapWorkspace(work.folder / "points").holds(split));
}

/// A flag a clip.
std::vector<char> innermost_of(const std::vector<std::optional<RigCamera>>& cameras) {
  std::vector<size_t> placed;
  std::vector<glm::dvec3> centres;
  for (size_t i = 0; i < cameras.size(); ++i) {
    if (!cameras[i]) continue;
    placed.push_back(i);
    centres.push_back(cameras[i]->camera.position());
  }
  std::vector<char> held_out(cameras.size(), 0);
  if (!placed.empty()) held_out[placed[innermost(centres)]] = 1;
  return held_out;
}

}  // namespace

PoseEstimate estimate_rig(const std::vector<RigClip>& clips,
                          const std::optional<std::vector<char>>& held_out,
                          const std::filesystem::path& folder, const PoseOptions& options,
                          const IngestProgress& progress) {
  check(!held_out || held_out->size() == clips.size(), "estimate_rig: one flag a clip");
  const ColmapWorkspace work(folder);
  const ColmapProgram colmap(work.folder / "colmap.log", progress);
  Fnv1a key;
  key.add(fmt::format("rig 1, colmap {}, {} {}", colmap.version(), options.lens_model,
                      options.intrinsics_per_camera()));
  const RigLens lens = rig_lens(clips, options);
  if (lens.mapped != "SIMPLE_RADIAL") key.add(lens.mapped);
  const auto stills = still_images(clips, key, progress);
  RigSolver solver{work, colmap, options, lens, overlap_remedy(stills), {}, {}, 1};
  for (size_t i = 0; i < stills.size(); ++i) {
    solver.cameras.push_back(clips[i].name);
    solver.names.push_back(ColmapWorkspace::image_name(i, stills[i].image));
    solver.max_error = std::max(solver.max_error, tight_error(stills[i].image.width));
  }
  Fnv1a split = key;
  if (held_out)
    split.add(held_out->data(), held_out->size());
  else
    split.add("innermost");
  PoseEstimate estimate;
  const PoseCache cache(options.cache);
  const bool was_known = is_known(work, key.hex(), split.hex());
  if (!was_known) {
    work.clear();
    estimate.reused = cache.fetch(split.hex(), work);
  }
  const auto largest = solver.solve(stills, key.hex(), estimate.warnings);
  estimate.cameras.resize(clips.size());
  if (!largest.empty()) {
    for (const ColmapPhoto& photo : read_colmap_model(solver.chosen()).photos) {
      const size_t i = solver.clip_of(photo.name);
      estimate.cameras[i] =
          RigCamera{clips[i].name, photo.camera, photo.lens, photo.lens_model, true};
    }
    estimate.held_out = held_out ? *held_out : innermost_of(estimate.cameras);
    solver.triangulate_training(estimate.held_out, split.hex());
    if (!was_known && !estimate.reused) cache.keep(split.hex(), work);
    if (const auto points = work.folder / "points" / "model"; std::filesystem::exists(points)) {
      ColmapModel model = read_colmap_model(points);
      for (const ColmapPhoto& photo : model.photos)
        if (auto& camera = estimate.cameras[solver.clip_of(photo.name)])
          camera->reprojection_error = photo.error;
      estimate.points = std::move(model.points);
      estimate.error = model.error;
    }
  }
  name_unregistered(clips, options, solver, estimate);
  return estimate;
}

}  // namespace tessera
