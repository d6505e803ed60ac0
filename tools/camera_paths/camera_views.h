// Named views for --cameras: the frames of a scene, or a transforms file as a camera path whose
// images need not exist. Also the cameras of a rig for players, and its frame rate.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "ingest/prepared/scene_reader.h"
#include "recon4d/model/gaussian_set.h"
#include "static3d/tessera4d/manifest.h"

namespace tessera {

struct NamedView {
  std::string name;  // "test/r_003", safe below a folder
  View view;
};

struct CameraChoice {
  std::filesystem::path cameras;  // scene folder, or a transforms file
  std::string split;              // empty: all frames
  std::optional<double> time;     // normalised; instead of the frames' own
};

/// Times and world are those of the model; none where no frame is of the split. Errors: InputError:
/// unreadable, no size, a frame without a time for a model that moves.
std::vector<NamedView> find_views(const CameraChoice& choice, const GaussianModel& model);
/// The same, and at least one. Errors: InputError: no frame of the split, too.
std::vector<NamedView> read_views(const CameraChoice& choice, const GaussianModel& model);

/// A pose of a transforms file, in the model's world.
struct KeyFrame {
  std::string name;   // as NamedView
  std::string where;  // file and frame, for messages
  Camera camera;
  std::optional<double> time;  // normalised, of the model; where the file states one
};

/// The frames of a transforms file, of one split or of all ("").
/// Errors: InputError: unreadable, no size of an image.
std::vector<KeyFrame> read_key_frames(const std::filesystem::path& file, const std::string& split,
                                      const GaussianModel& model);

/// "train", "val" or "test". Errors: InputError.
Split parse_split(const std::string& name);

/// The scene with its images on the model's background, times and cameras those of the model, which
/// was read from `model_path`: where a window of this scene was trained, the frames of its core.
/// `options`: what of it is loaded; background and allow_static are set here, `window` where it is
/// not. Errors: as
/// load_scene.
Scene scene_for(const GaussianModel& model, const std::filesystem::path& model_path,
                const std::filesystem::path& path, SceneOptions options = {});

struct Rig {
  std::vector<PlayerCamera> cameras;  // in the model's world; each place once, at most 32
  double fps = 0;                     // 0: not known
};

/// Of the frames of a scene with that time axis, in whose world the model is.
Rig rig_of_views(const std::vector<NamedView>& views, const TimeAxis& axis);
/// Of `cameras` (a scene folder or transforms file), else of the scene that the run folder
/// `model` was trained on, where that is still there, else none. Errors: InputError: `cameras` that
/// cannot be read.
Rig rig_of(const std::string& cameras, const std::string& model_path, const GaussianModel& model);

}  // namespace tessera
