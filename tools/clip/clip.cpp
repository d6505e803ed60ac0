// Determines the kind of a model file by its first bytes.
#include "tools/clip/clip.h"

#include <fmt/format.h>

#include <fstream>
#include <memory>
#include <utility>

#include "ingest/prepared/scene_reader.h"
#include "kernels/base/errors.h"
#include "recon4d/model/checkpoint.h"
#include "recon4d/model/model_file.h"
#include "recon4d/options/train_options.h"
#include "static3d/formats/splat_file.h"
#include "static3d/line_motion/line_formats.h"
#include "static3d/tessera4d/tessera4d.h"
#include "static3d/tessera4d/windowed_file.h"
#include "tools/session/run_folder.h"
#include "tools/session/windows_folder.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
constexpr const char* kAccepted =
    "expected a run folder, a checkpoint, a Tessera 4D .ply, .t4d or folder, or splats (.ply, "
    ".ftgs.ply, .sogst.ply, .spz, .sog, .splat)";

fs::path model_file_of(const fs::path& path) {
  if (!fs::exists(path))
    throw InputError(fmt::format("{}: no such file or folder; {}", path.string(), kAccepted));
  if (!fs::is_directory(path)) return path;
  for (const fs::path& folder : {path, run_folder_of(path)})
    for (const char* name : {"model.ply", "checkpoint.ckpt"})
      if (fs::exists(folder / name)) return folder / name;
  if (is_tessera4d_folder(path)) return path / kTessera4dManifest;
  if (opens_as_scene(path))
    throw InputError(fmt::format("{0}: is a scene, no model; train one: tessera train {0} -o RUN",
                                 path.string()));
  throw InputError(
      fmt::format("{0}: holds no model; {1}; of a capture `tessera run {0} -o OUT` makes one",
                  path.string(), kAccepted));
}

GaussianModel from_splats(const fs::path& path, std::vector<std::string>& warnings) {
  SplatFile file = load_splat_file(path);
  warnings = std::move(file.warnings);
  return model_of(std::move(file));
}

/// One window that is the whole clip.
void take_model(GaussianModel model, Clip& clip) {
  clip.head = std::make_shared<GaussianModel>(std::move(model));
  clip.windows = {{FileWindow{}}, [head = clip.head](int) { return head->clone_values(); }};
}

void take_windows(WindowModels windows, const TimeAxis& axis, Clip& clip) {
  clip.windows = std::move(windows);
  for (int i = 0; i < int(clip.count()) && (i == 0 || !clip.head->moves()); ++i)
    clip.head = std::make_shared<GaussianModel>(clip.windows.load(i));
  clip.head->time_axis = axis;
}

void take_folder(const WindowsFolder& folder, Clip& clip) {
  WindowsPlan plan = folder.read();
  require_all_windows(folder, plan);
  clip.file = folder.root;
  clip.stills = folder.static_scene();
  for (size_t i = 0; i < plan.windows.size(); ++i)
    plan.windows[i].light =
        RunFolder{folder.window_run(int64_t(i))}.read_config().value("light", kSameLight);
  clip.load_static = [folder, axis = plan.clip] {
    GaussianModel fixed = load_model(RunFolder{folder.static_run()}.model());
    fixed.time_axis = axis;
    return fixed;
  };
  take_windows(
      {std::move(plan.windows),
       [folder](int window) { return load_model(RunFolder{folder.window_run(window)}.model()); }},
      plan.clip, clip);
}

void take_tessera4d(const fs::path& path, Clip& clip) {
  const auto parts = std::make_shared<Tessera4dParts>(path);
  clip.bytes = parts->bytes();
  if (parts->windows().size() == 1) {
    take_model(parts->load(0), clip);
  } else {
    clip.load_static = [parts] { return parts->load_static(); };
    take_windows({parts->windows(), [parts](int window) { return parts->load(window); }},
                 parts->clip(), clip);
  }
  clip.warnings = parts->warnings();
}

}  // namespace

void Clip::edit(const std::function<void(GaussianModel&)>& change) {
  change(*head);
  if (count() == 1) return;
  windows.load = [change, load = std::move(windows.load)](int window) {
    GaussianModel model = load(window);
    change(model);
    return model;
  };
  load_static = [change, load = std::move(load_static)] {
    GaussianModel model = load();
    change(model);
    return model;
  };
}

ModelKind model_kind(const fs::path& file) {
  if (file.filename() == kTessera4dManifest && is_tessera4d_folder(file.parent_path()))
    return ModelKind::kTessera4d;
  std::ifstream stream(file, std::ios::binary);
  char head[8] = {};
  stream.read(head, sizeof head);
  const std::string_view start(head, size_t(stream.gcount()));
  if (start == "TESSCKPT") return ModelKind::kCheckpoint;
  if (is_tessera4d(start)) return ModelKind::kTessera4d;
  if (start.starts_with("ply") && is_tessera_model(file)) return ModelKind::kTesseraPly;
  if (is_line_file(file)) return ModelKind::kLines;
  return is_splat_file(file, start) ? ModelKind::kSplats : ModelKind::kNone;
}

Clip load_clip(const fs::path& path) {
  Clip clip;
  clip.named = path;
  if (const WindowsFolder folder = windows_folder_of(path); folder.exists()) {
    take_folder(folder, clip);
    return clip;
  }
  clip.file = model_file_of(path);
  switch (model_kind(clip.file)) {
    case ModelKind::kCheckpoint: {
      Checkpoint checkpoint = load_checkpoint(clip.file);
      take_model(baked_model(std::move(checkpoint.state), checkpoint.options), clip);
      return clip;
    }
    case ModelKind::kTesseraPly:
      take_model(load_model(clip.file), clip);
      break;
    case ModelKind::kTessera4d:
      take_tessera4d(
          clip.file.filename() == kTessera4dManifest ? clip.file.parent_path() : clip.file, clip);
      return clip;
    case ModelKind::kLines: {
      LineFile lines = load_line_file(clip.file);
      take_model(std::move(lines.model), clip);
      clip.warnings = std::move(lines.warnings);
      break;
    }
    case ModelKind::kSplats:
      take_model(from_splats(clip.file, clip.warnings), clip);
      break;
    case ModelKind::kNone:
      throw InputError(fmt::format("{}: not a model; {}", clip.file.string(), kAccepted));
  }
  clip.bytes = int64_t(fs::file_size(clip.file));
  return clip;
}

void replace_background(const std::string& background, GaussianModel& model) {
  if (background.empty()) return;
  model.background = parse_background(background);
  model.environment = {};
}

}  // namespace tessera
