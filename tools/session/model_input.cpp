// Determines the kind of a model file by its first bytes.
#include "tools/session/model_input.h"

#include <fmt/format.h>

#include <fstream>
#include <memory>
#include <utility>

#include "kernels/base/errors.h"
#include "recon4d/model/checkpoint.h"
#include "recon4d/model/model_file.h"
#include "recon4d/options/train_options.h"
#include "static3d/formats/splat_file.h"
#include "static3d/tessera4d/tessera4d.h"
#include "static3d/tessera4d/windowed_file.h"
#include "tools/session/run_folder.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
constexpr const char* kAccepted =
    "expected a run folder, a checkpoint, a Tessera 4D .ply, .t4d or folder, or splats (.ply, "
    ".spz, .sog, .splat)";

fs::path model_file_of(const fs::path& path) {
  if (!fs::exists(path))
    throw InputError(fmt::format("{}: no such file or folder; {}", path.string(), kAccepted));
  if (!fs::is_directory(path)) return path;
  for (const fs::path& folder : {path, run_folder_of(path)})
    for (const char* name : {"model.ply", "checkpoint.ckpt"})
      if (fs::exists(folder / name)) return folder / name;
  if (is_tessera4d_folder(path)) return path / kTessera4dManifest;
  throw InputError(fmt::format(
      "{}: has neither model.ply nor checkpoint.ckpt nor a Tessera 4D manifest.json; {}",
      path.string(), kAccepted));
}

GaussianModel from_splats(const fs::path& path, std::vector<std::string>& warnings) {
  SplatFile file = load_splat_file(path);
  GaussianModel model;
  model.static_set = std::move(file.set);
  model.drawing.sh_degree = file.sh_degree;
  warnings = std::move(file.warnings);
  return model;
}

}  // namespace

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
  return is_splat_file(file, start) ? ModelKind::kSplats : ModelKind::kNone;
}

ModelInput load_model_input(const fs::path& path) {
  ModelInput input;
  input.file = model_file_of(path);
  switch (model_kind(input.file)) {
    case ModelKind::kCheckpoint: {
      Checkpoint checkpoint = load_checkpoint(input.file);
      input.model = baked_model(std::move(checkpoint.state), checkpoint.options);
      input.with_optimizer = true;
      break;
    }
    case ModelKind::kTesseraPly:
      input.model = load_model(input.file);
      break;
    case ModelKind::kTessera4d: {
      const bool folder = input.file.filename() == kTessera4dManifest;
      Tessera4dInput read = load_tessera4d(folder ? input.file.parent_path() : input.file);
      input.model = std::move(read.model);
      input.warnings = std::move(read.warnings);
      input.bytes = read.bytes;
      return input;
    }
    case ModelKind::kSplats:
      input.model = from_splats(input.file, input.warnings);
      break;
    case ModelKind::kNone:
      throw InputError(fmt::format("{}: not a model; {}", input.file.string(), kAccepted));
  }
  input.bytes = int64_t(fs::file_size(input.file));
  return input;
}

std::optional<ClipModels> clip_of(const fs::path& path) {
  if (const WindowsFolder folder = windows_folder_of(path); folder.exists())
    return clip_models(folder);
  const bool is_folder = is_tessera4d_folder(path);
  if (!is_folder && !(fs::is_regular_file(path) && model_kind(path) == ModelKind::kTessera4d))
    return std::nullopt;
  const auto parts = std::make_shared<Tessera4dParts>(path);
  if (parts->manifest().windows.empty()) return std::nullopt;
  ClipModels clip = clip_with_head(
      {parts->windows(), [parts](int index) { return parts->load(index); }}, parts->clip());
  clip.bytes = parts->bytes();
  return clip;
}

void replace_background(const std::string& background, GaussianModel& model) {
  if (background.empty()) return;
  model.background = parse_background(background);
  model.environment = {};
}

}  // namespace tessera
