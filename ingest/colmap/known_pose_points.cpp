// Triangulates points with timesteps from known poses: static points once, moving points at each
// timestep. Poses are not changed.
#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "ingest/colmap/colmap_model.h"
#include "ingest/colmap/colmap_workspace.h"
#include "ingest/colmap/pose_estimation.h"
#include "kernels/base/errors.h"

namespace tessera {
namespace {

constexpr double kErrorFactor = 2;  // known poses are off by their own error

/// One triangulation: images with masks of the clips that have one.
struct PosedStills {
  std::vector<size_t> clips;  // increasing
  std::vector<StillImage> stills;
};

std::string key_of(const PosedStills& set, const std::vector<RigClip>& clips,
                   const std::string& version) {
  Fnv1a key;
  key.add("points 1, colmap " + version);
  for (size_t i = 0; i < set.clips.size(); ++i) {
    const RigCamera& rig = *clips[set.clips[i]].camera;
    const Camera& c = rig.camera;
    key.add(fmt::format("{} {}", set.clips[i], colmap_lens_line(rig)));
    key.add(&c.cam_from_world, sizeof c.cam_from_world);
    key.add(&c.translation, sizeof c.translation);
    key.add(set.stills[i].image.data.data(), set.stills[i].image.data.size());
    key.add(set.stills[i].mask.data.data(), set.stills[i].mask.data.size());
  }
  return key.hex();
}

PointCloud triangulate_set(const PosedStills& set, const std::vector<RigClip>& clips,
                           const std::filesystem::path& folder, const ColmapProgram& colmap) {
  if (set.clips.size() < 2) return {};
  const ColmapWorkspace work(folder);
  const auto out = work.folder / "points" / "model";
  const std::string key = key_of(set, clips, colmap.version());
  const bool is_known = work.holds(key);
  if (!is_known) {
    work.clear();
    std::vector<PosedImage> posed;
    double max_error = 1;
    for (size_t i = 0; i < set.clips.size(); ++i) {
      posed.push_back({work.add(set.clips[i], set.stills[i]), *clips[set.clips[i]].camera});
      max_error = std::max(max_error, kErrorFactor * tight_error(set.stills[i].image.width));
    }
    work.find_matches(colmap, {"SIMPLE_RADIAL", true}, posed.size());
    write_posed_model(work.folder / "points" / "posed", posed);
    const auto triangulated = with_points([&] {
      work.triangulate(colmap, work.folder / "points" / "posed", out, max_error);
      return true;
    });
    if (!triangulated) return {};  // nothing moves at this timestep
  }
  PointCloud points = read_colmap_model(out).points;
  if (!is_known) work.store_key(key);  // not before it was read: its files may be incomplete
  return points;
}

void append(PointCloud& all, const PointCloud& some, double time, bool still) {
  all.position.insert(all.position.end(), some.position.begin(), some.position.end());
  all.colour.insert(all.colour.end(), some.colour.begin(), some.colour.end());
  all.time.resize(all.position.size(), float(time));
  all.still.resize(all.position.size(), still);
}

/// The images of the training cameras: still images, and for each timestep the moving pixels.
struct SeenByCameras {
  PosedStills still;
  std::vector<PosedStills> moving;  // one a timestep
};

/// Decodes a clip once: the frames behind its median, and those of the instants.
void look(const RigClip& clip, size_t index, const std::vector<RigInstant>& instants,
          SeenByCameras& seen) {
  const auto spread = spread_frames(clip.timeline.ticks.size(), kStillSamples);
  std::map<size_t, Image8> images;
  for (const size_t frame : spread) images[frame];
  for (const RigInstant& instant : instants)
    if (instant.frame[index]) images[*instant.frame[index]];
  std::vector<size_t> wanted;
  for (const auto& [frame, image] : images) wanted.push_back(frame);
  auto decoded = sample_images(clip, wanted);
  for (size_t i = 0; i < wanted.size(); ++i) images[wanted[i]] = std::move(decoded[i]);
  std::vector<Image8> samples;
  for (const size_t frame : spread) samples.push_back(images[frame]);
  const StillImage still = still_image(samples);
  for (size_t i = 0; i < instants.size(); ++i)
    if (const auto frame = instants[i].frame[index]) {
      seen.moving[i].clips.push_back(index);
      seen.moving[i].stills.push_back({images[*frame], moving_mask(images[*frame], still)});
    }
  seen.still.clips.push_back(index);
  seen.still.stills.push_back(still);
}

}  // namespace

PointCloud triangulate_instants(const std::vector<RigClip>& clips,
                                const std::vector<char>& held_out,
                                const std::vector<RigInstant>& instants,
                                const std::filesystem::path& folder, const PoseOptions&,
                                const IngestProgress& progress) {
  check(held_out.size() == clips.size(), "triangulate_instants: one flag a clip");
  const ColmapProgram colmap(std::filesystem::absolute(folder) / "colmap.log", progress);
  SeenByCameras seen;
  seen.moving.resize(instants.size());
  for (size_t i = 0; i < clips.size(); ++i) {
    progress("reading frames for the initial points", int64_t(i), int64_t(clips.size()));
    if (clips[i].camera && !held_out[i]) look(clips[i], i, instants, seen);
  }
  PointCloud points;
  append(points, triangulate_set(seen.still, clips, folder / "still", colmap),
         instants.empty() ? 0 : instants.front().time, true);
  for (size_t i = 0; i < instants.size(); ++i)
    append(points,
           triangulate_set(seen.moving[i], clips, folder / fmt::format("instant{:03}", i), colmap),
           instants[i].time, false);
  return points;
}

}  // namespace tessera
