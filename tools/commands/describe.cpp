// Determines the kind of a path and describes models, checkpoints, run folders, splat sequences and
// point clouds. describe_scene.cpp describes scenes and captures.
#include "tools/commands/describe.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "ingest/files/atomic_file.h"
#include "ingest/files/json_file.h"
#include "ingest/files/ply_header.h"
#include "ingest/layouts/capture_layout.h"
#include "ingest/prepared/transforms_json.h"
#include "kernels/base/errors.h"
#include "recon4d/model/checkpoint.h"
#include "recon4d/model/model_info.h"
#include "static3d/tessera4d/windowed_file.h"
#include "tools/clip/clip.h"
#include "tools/export/formats.h"
#include "tools/session/model_scene.h"
#include "tools/session/run_folder.h"
#include "tools/session/windows_folder.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
constexpr const char* kKnown =
    "expected a model or splat .ply, a checkpoint, a point cloud .ply, a run folder, a scene or a "
    "capture";

json described(const char* kind, const fs::path& path) {
  return {{"kind", kind}, {"path", path.string()}};
}

void describe_gaussians(const GaussianModel& model, const fs::path& path, bool with_shipped,
                        const std::vector<std::string>& warnings, json& info) {
  info.update(model_info(model));
  if (with_shipped) info["shipped_bytes"] = shipped_bytes(path.string(), model);
  if (!warnings.empty()) info["warnings"] = warnings;
}

json describe_model(const char* kind, const fs::path& path, bool with_shipped) {
  const Clip clip = load_clip(path);
  json info = described(kind, path);
  info["file"] = clip.file.string();
  info["bytes"] = fs::file_size(clip.file);
  describe_gaussians(*clip.head, path, with_shipped, clip.warnings, info);
  return info;
}

json describe_checkpoint(const fs::path& path, bool with_shipped) {
  json info = describe_model("checkpoint", path, with_shipped);
  const json header = read_checkpoint_header(path);
  for (const char* key : {"iteration", "finished", "seconds", "options", "provenance"})
    info[key] = header.at(key);
  return info;
}

/// A clip that was trained window by window.
json describe_windows(const WindowsFolder& folder) {
  const WindowsPlan plan = folder.read();
  json info = described("clip in windows", folder.root);
  const std::string scene = scene_of_model(folder.root);
  info["scene"] = scene.empty() ? plan.scene : scene;
  info["windows"] = plan.windows.size();
  info["window_seconds"] = plan.clip.duration / double(plan.windows.size());
  info["overlap"] = plan.overlap;
  info["time_axis"] = {{"origin", plan.clip.origin}, {"duration", plan.clip.duration}};
  const std::vector<int64_t> missing = folder.missing(plan);
  info["trained"] = plan.windows.size() - missing.size();
  info["missing"] = missing;
  return info;
}

/// `path`: the single file, or the manifest of a folder. Windows are told by the manifest alone.
json describe_tessera4d(const fs::path& path, bool with_shipped) {
  const bool folder = path.filename() == kTessera4dManifest;
  const fs::path place = folder ? path.parent_path() : path;
  Tessera4dParts parts = open_tessera4d(place);
  const Tessera4dManifest& manifest = parts.manifest();
  json info = described("Tessera 4D file", place);
  info["bytes"] = parts.bytes();
  info["lossless"] = manifest.lossless;
  info["generator"] = manifest.generator;
  info["blocks"] = manifest.blocks.size();
  if (parts.windows().size() == 1) {
    const GaussianModel model = parts.load(0);
    describe_gaussians(model, path, with_shipped, parts.warnings(), info);
    return info;
  }
  info["windows"] = parts.windows().size();
  info["num_static"] = manifest.gaussians(false);
  info["num_dynamic"] = manifest.gaussians(true);
  info["num_gaussians"] = manifest.gaussians(false) + manifest.gaussians(true);
  info["time_axis"] = {{"origin", parts.clip().origin}, {"duration", parts.clip().duration}};
  return info;
}

/// Elements and properties; a cloud is a `vertex` with positions and nothing of a splat.
json describe_other_ply(const fs::path& path, const PlyHeader& header) {
  json info = described("PLY", path);
  info["bytes"] = fs::file_size(path);
  for (const PlyElementLayout& element : header.elements) {
    json names = json::array();
    for (const PlyPropertyLayout& property : element.properties) names.push_back(property.name);
    const auto has = [&](const char* name) {
      return std::find(names.begin(), names.end(), name) != names.end();
    };
    if (element.name == "vertex" && has("x") && has("y") && has("z")) {
      info["kind"] = "point cloud";
      info["points"] = element.rows;
      info["has_colour"] = has("red");
    }
    info["elements"][element.name] = {{"rows", element.rows}, {"properties", names}};
  }
  return info;
}

bool is_splat_header(const PlyHeader& header) {
  for (const PlyElementLayout& element : header.elements) {
    if (element.name == "chunk") return true;  // compressed splats
    for (const PlyPropertyLayout& property : element.properties)
      if (property.name == "opacity" || property.name == "rot_0") return true;
  }
  return false;
}

json describe_file(const fs::path& path, bool with_shipped) {
  switch (model_kind(path)) {
    case ModelKind::kCheckpoint:
      return describe_checkpoint(path, with_shipped);
    case ModelKind::kTesseraPly:
      return describe_model("Tessera 4D model", path, with_shipped);
    case ModelKind::kTessera4d:
      return describe_tessera4d(path, with_shipped);
    case ModelKind::kLines:
      return describe_model("4D splats", path, with_shipped);
    case ModelKind::kSplats: {
      const std::string text = read_text_file(path);
      if (!text.starts_with("ply")) return describe_model("splats", path, with_shipped);
      const PlyHeader header = parse_ply_header(path, text);
      return is_splat_header(header) ? describe_model("3DGS model", path, with_shipped)
                                     : describe_other_ply(path, header);
    }
    case ModelKind::kNone:
      break;
  }
  throw InputError(fmt::format("{}: unrecognised file type; {}", path.string(), kKnown));
}

json describe_run(const RunFolder& run, bool with_shipped) {
  json info = described("run", run.root);
  const bool has_model = fs::exists(run.model()), has_checkpoint = fs::exists(run.checkpoint());
  if (has_model || has_checkpoint) info = describe_model("run", run.root, with_shipped);
  if (has_checkpoint) {
    const json header = read_checkpoint_header(run.checkpoint());
    for (const char* key : {"iteration", "finished", "seconds"}) info[key] = header.at(key);
  }
  info["config"] = run.read_config();
  if (fs::exists(run.metrics())) {
    const json metrics = read_json(run.metrics());
    for (const char* key : {"split", "psnr", "ssim"})
      info["scores"][key] = metrics.value(key, json());
  }
  if (const std::string scene = scene_of_model(run.root); !scene.empty()) info["scene"] = scene;
  return info;
}

json describe_splat_sequence(const fs::path& folder) {
  const json manifest = read_json(folder / "manifest.json");
  if (!manifest.is_object() || !manifest.contains("format"))
    throw InputError(
        fmt::format("{}: a manifest.json without format; {}", folder.string(), kKnown));
  json info = described("splat sequence", folder);
  for (const char* key : {"format", "count", "fps", "time_axis", "bytes", "bounds", "counters"})
    info[key] = manifest.value(key, json());
  return info;
}

json describe_folder(const fs::path& path, bool with_shipped) {
  if (const WindowsFolder windows = windows_folder_of(path); windows.exists())
    return describe_windows(windows);
  if (const RunFolder run{run_folder_of(path)}; run.exists())
    return describe_run(run, with_shipped);
  if (has_transforms(path)) return describe_transforms(path);
  if (has_clips(path)) return describe_videos(path);
  if (is_tessera4d_folder(path)) return describe_tessera4d(path / kTessera4dManifest, with_shipped);
  if (fs::exists(path / "manifest.json")) return describe_splat_sequence(path);
  if (fs::exists(path / "model.ply")) return describe_file(path / "model.ply", with_shipped);
  if (const std::optional<json> sequences = describe_sequences(path)) return *sequences;
  if (find_video_folders(path).evidence == RigEvidence::kRig) return describe_videos(path);
  if (const std::optional<json> photos = describe_photos(path)) return *photos;
  throw InputError(fmt::format("{}: holds no files of a known type; {}", path.string(), kKnown));
}

}  // namespace

json describe(const fs::path& path, bool with_shipped) {
  if (!fs::exists(path))
    throw InputError(fmt::format("{}: no such file or folder; {}", path.string(), kKnown));
  json info = fs::is_directory(path) ? describe_folder(path, with_shipped)
                                     : describe_file(path, with_shipped);
  if (with_shipped && !info.contains("shipped_bytes"))
    throw InputError(fmt::format("{}: is no model but a {}; leave --shipped out", path.string(),
                                 info["kind"].get<std::string>()));
  return info;
}

}  // namespace tessera
