// The scores of a model on a split of a scene: those of every view, and means under their names.
// Images and progress go to a callback. Source: method A.15 (8-bit images, mean of PSNR); failure
// modes A9, A14, D1–D3.
#pragma once
#include <functional>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "recon4d/evaluation/dynamic_share.h"
#include "recon4d/evaluation/pixel_sums.h"
#include "recon4d/evaluation/structure_scores.h"
#include "recon4d/evaluation/temporal_scores.h"
#include "recon4d/evaluation/timestep_scores.h"

namespace tessera {

/// Scores that not every view has: nothing where they are undefined or were not asked for. Their
/// names and definitions: score_rows.h.
struct OptionalScores : StructureScores {
  std::optional<double> lpips;  // where a network was given
  /// Over the pixels that move and the others (DynamicRegions); nothing where the camera moves or
  /// there is no such pixel.
  std::optional<double> psnr_dynamic, psnr_static;
  /// PSNR of the same pixels after the colour fit of the camera, one fit over all pixels of all its
  /// scored views. Nothing before the last view is scored.
  std::optional<double> psnr_fit, psnr_fit_dynamic, psnr_fit_static;
};

struct ViewScore : OptionalScores {
  std::string name, camera;
  double time = 0;  // normalised
  int width = 0, height = 0;
  double psnr = 0, psnr_float = 0;  // dB: 8-bit, un-quantised
  double mse = 0;                   // 8-bit, range 1
  /// Of a frame outside training: its timestep was trained on, from other cameras / its camera was,
  /// at other timesteps. A frame can be both (one image was withheld) or neither (D-NeRF).
  bool held_out_view = false, held_out_time = false;
  bool masked = false;  // the frame has a mask: the numbers above are of the pixels it uses
};

/// Means over some views; nothing where there is none. All but PSNR: over the views that have one.
struct MeanScore : OptionalScores {
  int64_t views = 0;
  std::optional<double> psnr, psnr_float;
  std::optional<double> psnr_of_mean_mse;  // not the mean of PSNR
  int64_t dynamic_views = 0;               // that have a psnr_dynamic
};

struct EvaluationReport {
  Split split = Split::kTest;
  std::vector<ViewScore> views;  // in the order of the scene
  MeanScore all, held_out_views, held_out_times;
  /// Frames outside training apart: the camera is new, the timestep is, both are, neither is (one
  /// image of a rig was withheld).
  MeanScore novel_view, novel_time, novel_view_and_time, withheld;
  std::vector<CameraColourFit> colour_fit;  // by name of camera
  std::map<std::string, double> clock_fit;  // by camera, normalised time; where it was asked for
  std::vector<TimestepScore> timesteps;     // ascending
  std::vector<ObjectScore> objects;         // by name, where boxes were given
  std::vector<FlickerScore> flicker;        // of the cameras that have one
  std::optional<MovingRegionScore> moving;  // where masks of what moves were given
  std::optional<int64_t> bytes;             // of the model's file; set by the caller
};

/// How much of the structure is scored: each step costs seconds where the one before costs tenths.
enum class StructureDetail { kNone, kSsim, kAll };  // kSsim: the reflected mean alone

struct EvaluateOptions {
  int batch = 4;  // views rendered at once; more are scored at once, where there are threads
  StructureDetail structure = StructureDetail::kAll;
  bool temporal = true;     // flicker, moving and still pixels apart
  bool fit_clocks = false;  // views are drawn and scored by the fitted clock of their camera
  bool pixel_sums = true;   // what PixelScores adds, all of `temporal` among it; false: PSNR alone
  /// LPIPS of two RGB images of one size; empty: none. Where a mask ignores, both are alike.
  std::function<double(const Image8& drawn, const Image8& truth)> lpips;
  /// What moves in a frame, one channel, of its size: values as MovingRegionScore has them; empty:
  /// not known.
  std::function<Image8(const Frame&)> moving_mask;
  /// Boxes of the objects that a frame shows; empty: objects are not scored.
  std::function<NamedBoxes(const Frame&)> object_boxes;
};

/// Each scored view with its image, in order; throwing stops the evaluation.
using ScoredCallback = std::function<void(const Frame& frame, const RenderedImage& image,
                                          const ViewScore& score, int64_t done, int64_t total)>;

/// Pixels that a frame's mask ignores do not count (metrics.h); frames without a used pixel are
/// left out. Errors: InputError: no frame in the split, or none with a used pixel; frames
/// composited on another background than the model's.
EvaluationReport evaluate(Backend& backend, const GaussianModel& model, const Scene& scene,
                          Split split, const EvaluateOptions& options,
                          const ScoredCallback& scored = {});

/// psnr, psnr_float, psnr_of_mean_mse, the scores of score_rows.h, dssim, dynamic_weight_inside,
/// moving_pixels_covered, definitions, num_gaussians, num_static, num_dynamic, bytes, split,
/// background, width, height (null when views differ), views,
/// held_out_views, held_out_times, novel_view, novel_time, novel_view_and_time, withheld,
/// colour_fit (by camera: gain, offset), clock_fit (by camera: seconds; null: not asked for),
/// timesteps and worst_timestep (time, frame_number, views, psnr, psnr_dynamic), objects (name,
/// psnr, worst, timesteps), flicker, per_view (with `masked`). What is undefined is null.
nlohmann::json to_json(const EvaluationReport& report, const GaussianModel& model);

}  // namespace tessera
