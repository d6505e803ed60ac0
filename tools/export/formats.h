// The request of `tessera export`, and its output: formats that hold the whole clip, or numbered
// files of one timestep each.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "recon4d/model/gaussian_set.h"
#include "recon4d/reduction/size_limit.h"
#include "static3d/tessera4d/tessera4d.h"
#include "tools/camera_paths/export_times.h"
#include "tools/clip/clip.h"

namespace tessera {

/// The options of `tessera export`.
struct ExportRequest {
  std::string model, out, format = "ply";
  ExportTimes times;  // of frames; its fps also of formats that hold time
  int spz_version = 3;
  bool page = false;                      // the player beside the frames
  bool single = false, lossless = false;  // of the Tessera 4D file
  double segment_seconds = 1;
  std::string cameras, audio;
  std::string title, description;  // of a page; empty: none
  std::string poster;              // of a page: an image file, or "auto"; empty: none
  bool truth = false;              // test images of the scene in the page
  std::optional<bool> clean;       // floaters leave; by default of a page whose scene is there
  int threads = 0;
  bool keep_world = false, overwrite = false, json = false;
};

struct TimeFormat {
  const char* name;  // of --format
  const char* doc;
  /// Writes the folder; `frames` (files), `bytes` and counters.
  nlohmann::json (*write)(const ExportRequest&, Clip&);
  bool is_tessera4d = true;  // takes --lossless, --segment, --audio
  bool has_rate = true;      // takes --fps and --cameras
  bool keeps_environment = false;
};
const std::vector<TimeFormat>& time_formats();
/// Nothing where frames are meant.
const TimeFormat* find_time_format(const std::string& name);

constexpr const char* kSingleTessera4d = "scene.t4d";
/// What a request says of the Tessera 4D file of `model`: with the cameras of the rig and its rate.
/// Errors: as rig_of.
Tessera4dOptions tessera4d_options(const ExportRequest& request, const GaussianModel& model);

/// Bytes of the file that `tessera export PATH --format tessera --single` writes for a model of
/// `path`, encoded in memory: three seconds of one core for 100,000 Gaussians.
int64_t shipped_bytes(const std::string& path, const GaussianModel& model);
/// The same of any model of the run folder `path`.
ShippedBytes shipped_bytes_of(const std::string& path);
/// Errors: InputError that states the least number: the file of any model of this scene has more
/// than `max_bytes`; 0: no limit. As load_scene.
void check_max_bytes(const std::string& scene, int64_t max_bytes);

/// Writes the folder; frames, bytes and counters, each frame of the window that is drawn at its
/// time; of several windows also `windows` and `peak_gaussians`. Errors: as export_times,
/// export_sequence.
nlohmann::json export_frames(const ExportRequest& request, const Clip& clip);

}  // namespace tessera
