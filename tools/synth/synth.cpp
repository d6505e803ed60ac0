// What: make_capture: a temporary folder is filled and then takes the place of `out`.
// Not: what is written into it (layout_*.cpp, ground_truth.cpp).
#include "tools/synth/synth.h"

#include <fmt/format.h>
#include <unistd.h>

#include <system_error>

#include "ingest/files/atomic_file.h"
#include "kernels/base/errors.h"
#include "tools/synth/ground_truth.h"
#include "tools/synth/layouts.h"
#include "tools/synth/world.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

void check_replaceable(const fs::path& out) {
  std::error_code ignored;
  if (!fs::exists(out, ignored)) return;
  if (!fs::is_directory(out, ignored))
    throw InputError(fmt::format("synth: {} is a file; name a folder", out.string()));
  if (fs::is_empty(out, ignored) || fs::exists(out / synth::kTruthFile, ignored)) return;
  throw InputError(
      fmt::format("synth: {} holds files that synth did not write; name an empty or a new folder",
                  out.string()));
}

/// A hidden sibling of the target that is removed unless it takes the target's place.
class PendingFolder {
 public:
  explicit PendingFolder(const fs::path& target) : target_(target) {
    const std::string name = target.filename().string();
    path_ = target.parent_path() / fmt::format(".{}.partial-{}", name, getpid());
    replaced_ = target.parent_path() / fmt::format(".{}.replaced-{}", name, getpid());
    make_folder(path_);
  }
  PendingFolder(const PendingFolder&) = delete;
  PendingFolder& operator=(const PendingFolder&) = delete;
  ~PendingFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }

  const fs::path& path() const { return path_; }

  void take_place() {
    std::error_code error, ignored;
    const bool old = fs::exists(target_, ignored);
    if (old) fs::rename(target_, replaced_, error);
    if (!error) fs::rename(path_, target_, error);
    if (error) {
      if (old && !fs::exists(target_, ignored)) fs::rename(replaced_, target_, ignored);
      throw InputError(
          fmt::format("synth: cannot write {}: {}; name a folder in a place that can "
                      "be written",
                      target_.string(), error.message()));
    }
    fs::remove_all(replaced_, ignored);
  }

 private:
  fs::path target_, path_, replaced_;
};

fs::path without_trailing_slash(const fs::path& out) {
  if (out.empty()) throw InputError("synth: the output has no name; name a folder");
  const fs::path normal = fs::absolute(out).lexically_normal();
  return normal.has_filename() ? normal : normal.parent_path();
}

}  // namespace

SynthReport make_capture(const SynthOptions& options, const std::filesystem::path& out,
                         const SynthProgress& progress) {
  const SynthOptions full = resolve_synth_options(options);
  const fs::path target = without_trailing_slash(out);
  check_replaceable(target);
  const synth::World world = synth::build_world(full.scene, full.seed, full.specular);
  PendingFolder pending(target);
  make_folder(pending.path() / synth::kTruthFolder);

  const bool dnerf = full.layout == SynthLayout::kDnerf;
  const synth::CaptureJob job{full, world, pending.path(), progress};
  const std::vector<synth::TrueView> views =
      dnerf ? synth::write_dnerf(job) : synth::write_videos(job);

  const PointCloud points = synth::sample_static_points(world, views, full.points, full.seed);
  synth::write_points(pending.path() / synth::kTruthFolder / "points.ply", points);
  write_text_file(pending.path() / synth::kTruthFile, synth::truth_json(full, world, views));
  pending.take_place();

  SynthReport report;
  report.cameras = dnerf ? 1 : full.cameras;
  report.images = dnerf ? int64_t(views.size()) : int64_t(full.cameras) * full.frames;
  report.points = int64_t(points.position.size());
  return report;
}

}  // namespace tessera
