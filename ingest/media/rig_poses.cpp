// What: one pose a camera of a rig that stands still: COLMAP on pictures without what moves.
// Not: poses that are known (known_pose_points.cpp) or change (moving_camera.cpp).
#include <fmt/format.h>

#include <algorithm>

#include "ingest/colmap_model.h"
#include "ingest/image_paths.h"
#include "ingest/media/colmap_workspace.h"
#include "ingest/media/pose_estimation.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

constexpr size_t kSamples = 9;  // frames of a clip behind its median
constexpr int kRounds = 2;      // of triangulation and adjustment: the third changes < 0.001 degrees
constexpr const char* kOverlapRemedy =
    "let neighbouring cameras see more of the same textured things, or pass --poses FILE";

struct RigSolver {
  const ColmapWorkspace& work;
  const ColmapProgram& colmap;
  const PoseOptions& options;
  std::vector<std::string> names;  // of the pictures, one a clip
  double max_error = 1;            // pixels, of the last rounds

  void map() const;
  std::filesystem::path refine(const ColmapModel& start, const std::string& lens) const;
  void choose_refined(const ColmapModel& mapped) const;
};

/// Registers cameras one after the other; models into work.sparse.
void RigSolver::map() const {
  std::filesystem::create_directories(work.sparse);
  colmap.run("mapper",
             {{"--database_path", work.database.string()},
              {"--image_path", work.pictures.string()},
              {"--output_path", work.sparse.string()},
              {"--Mapper.min_model_size", "3"},
              {"--Mapper.ba_refine_principal_point", "0"}},
             "colmap: registering cameras", "Registering image", int64_t(names.size()),
             kOverlapRemedy);
}

std::vector<PosedPicture> posed_pictures(const ColmapModel& model) {
  std::vector<PosedPicture> pictures;
  for (const ColmapPhoto& photo : model.photos)
    pictures.push_back({photo.name, {photo.name, photo.camera, photo.lens, photo.lens_model}});
  return pictures;
}

/// Tracks are made anew from exact matches and everything is adjusted, twice: the mapper's own
/// tracks hold features that are off by up to 4 pixels. Returns the model's folder.
std::filesystem::path RigSolver::refine(const ColmapModel& start, const std::string& lens) const {
  auto pictures = posed_pictures(start);
  if (!lens.empty())
    for (PosedPicture& picture : pictures)
      picture.camera.lens_model = lens, picture.camera.lens = {};
  const auto folder = work.folder / "refined" / (lens.empty() ? "as mapped" : lens);
  auto model = folder / "start";
  write_posed_model(model, pictures);
  for (int round = 0; round < kRounds; ++round) {
    const auto points = folder / fmt::format("points{}", round);
    const auto adjusted = folder / fmt::format("adjusted{}", round);
    std::filesystem::create_directories(adjusted);
    work.triangulate(colmap, model, points, max_error);
    colmap.run("bundle_adjuster",
               {{"--input_path", points.string()},
                {"--output_path", adjusted.string()},
                {"--BundleAdjustment.refine_principal_point", "0"},
                {"--BundleAdjustment.max_num_iterations", "200"}},
               "colmap: adjusting cameras");
    model = adjusted;
  }
  return model;
}

/// The result, as a text model in work.folder/refined/chosen. Where no lens was asked for, one
/// without distortion is taken if it explains as many points: distortion that is not there costs
/// accuracy. Where a lens fits so badly that half of the points go, the mapper's result stays.
void RigSolver::choose_refined(const ColmapModel& mapped) const {
  ColmapModel chosen = read_colmap_model(refine(mapped, ""));
  if (options.lens_model.empty()) {
    ColmapModel plain = read_colmap_model(refine(mapped, "SIMPLE_PINHOLE"));
    if (plain.points.position.size() >= chosen.points.position.size()) chosen = std::move(plain);
  }
  const bool fits = 2 * chosen.points.position.size() >= mapped.points.position.size() &&
                    chosen.photos.size() == mapped.photos.size();
  write_posed_model(work.folder / "refined" / "chosen", posed_pictures(fits ? chosen : mapped));
}

/// Writes the still pictures and adds them to the key.
std::vector<StillPicture> still_pictures(const std::vector<RigClip>& clips, Fnv1a& key,
                                         const IngestProgress& progress) {
  std::vector<StillPicture> stills;
  for (const RigClip& clip : clips) {
    progress("reading frames for the camera poses", int64_t(stills.size()), int64_t(clips.size()));
    stills.push_back(still_picture(
        sample_pictures(clip, spread_frames(clip.timeline.ticks.size(), kSamples))));
    const Image8& picture = stills.back().picture;
    key.add(fmt::format("{} {}x{}", clip.name, picture.width, picture.height));
    key.add(picture.data.data(), picture.data.size());
    key.add(stills.back().mask.data.data(), stills.back().mask.data.size());
  }
  return stills;
}

void name_unregistered(const std::vector<RigClip>& clips, const PoseOptions& options,
                       const std::filesystem::path& log, PoseEstimate& estimate) {
  std::vector<std::string> missing;
  for (size_t i = 0; i < clips.size(); ++i)
    if (!estimate.cameras[i]) missing.push_back(clips[i].name);
  if (clips.size() - missing.size() < 2)
    throw InputError(fmt::format("COLMAP registered {} of {} cameras, expected at least 2 (log: "
                                 "{}); {}",
                                 clips.size() - missing.size(), clips.size(), log.string(),
                                 kOverlapRemedy));
  if (missing.empty()) return;
  const std::string seen = fmt::format("COLMAP registered {} of {} cameras, not {}",
                                       clips.size() - missing.size(), clips.size(),
                                       fmt::join(missing, ", "));
  if (options.strict)
    throw InputError(fmt::format("{} (log: {}); {}, or leave --strict out to go on without", seen,
                                 log.string(), kOverlapRemedy));
  estimate.warnings.push_back(seen + "; the scene is made without");
}

/// Points and colours of the training cameras alone, into work.folder/points.
void triangulate_training(const RigSolver& solver, const std::vector<char>& held_out) {
  std::vector<PosedPicture> training;
  for (PosedPicture& picture :
       posed_pictures(read_colmap_model(solver.work.folder / "refined" / "chosen"))) {
    const auto found = std::find(solver.names.begin(), solver.names.end(), picture.name);
    check(found != solver.names.end(), "COLMAP names a picture that it was not given");
    if (!held_out[size_t(found - solver.names.begin())]) training.push_back(std::move(picture));
  }
  const auto posed = solver.work.folder / "points" / "posed", out = solver.work.folder / "points";
  write_posed_model(posed, training);
  if (training.size() > 1) solver.work.triangulate(solver.colmap, posed, out / "model", 2 * solver.max_error);
}

}  // namespace

PoseEstimate estimate_rig(const std::vector<RigClip>& clips, const std::vector<char>& held_out,
                          const std::filesystem::path& folder, const PoseOptions& options,
                          const IngestProgress& progress) {
  check(held_out.size() == clips.size(), "estimate_rig: one flag a clip");
  const ColmapWorkspace work(folder);
  const ColmapProgram colmap(work.folder / "colmap.log", progress);
  Fnv1a key;
  key.add(fmt::format("rig 1, colmap {}, {} {}", colmap.version(), options.lens_model,
                      options.intrinsics_per_camera));
  key.add(held_out.data(), held_out.size());
  const auto stills = still_pictures(clips, key, progress);
  RigSolver solver{work, colmap, options, {}, 1};
  int width = 0;
  for (size_t i = 0; i < stills.size(); ++i) {
    solver.names.push_back(ColmapWorkspace::picture_name(i, stills[i].picture));
    width = std::max(width, stills[i].picture.width);
  }
  solver.max_error = tight_error(width);
  PoseEstimate estimate;
  const bool is_known = work.holds(key.hex());
  if (!is_known) {
    work.clear();
    for (size_t i = 0; i < stills.size(); ++i) work.add(i, stills[i]);
    const std::string lens = options.lens_model.empty() ? "SIMPLE_RADIAL" : options.lens_model;
    work.find_matches(colmap, {lens, options.intrinsics_per_camera}, clips.size());
    solver.map();
  }
  const auto largest = largest_colmap_model(work.sparse, estimate.warnings);
  estimate.cameras.resize(clips.size());
  if (!largest.empty()) {
    if (!is_known) {
      solver.choose_refined(read_colmap_model(largest));
      triangulate_training(solver, held_out);
      work.store_key(key.hex());
    }
    for (ColmapPhoto& photo : read_colmap_model(work.folder / "refined" / "chosen").photos) {
      const auto i = size_t(std::find(solver.names.begin(), solver.names.end(), photo.name) -
                            solver.names.begin());
      estimate.cameras[i] = {clips[i].name, photo.camera, photo.lens, photo.lens_model};
    }
    if (const auto points = work.folder / "points" / "model"; std::filesystem::exists(points))
      estimate.points = read_colmap_model(points).points;
  }
  name_unregistered(clips, options, colmap.log(), estimate);
  return estimate;
}

}  // namespace tessera
