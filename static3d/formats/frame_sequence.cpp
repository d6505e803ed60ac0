// Slices of a model at every timestep, each saved as a static file, and the manifest.
#include "static3d/formats/frame_sequence.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "ingest/files/atomic_file.h"
#include "ingest/files/json_file.h"
#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"
#include "kernels/load_gaussian.h"
#include "recon4d/model/element_edits.h"
#include "static3d/transform/scene_box.h"
#include "static3d/transform/slicer.h"

namespace tessera {
namespace {

constexpr const char* kManifest = "manifest.json";

/// Bounds of the means of a frame, outliers left aside.
struct Bounds {
  Vec3<float> low{INFINITY, INFINITY, INFINITY}, high{-INFINITY, -INFINITY, -INFINITY};

  void add(const Vec3<float>& low_point, const Vec3<float>& high_point) {
    low = glm::min(low, low_point);
    high = glm::max(high, high_point);
  }
  nlohmann::json to_json() const {
    if (low[0] > high[0]) return nullptr;
    return {{"min", {low[0], low[1], low[2]}}, {"max", {high[0], high[1], high[2]}}};
  }
};

/// A model whose frames are written: all of the sequence, or those of one window.
struct SlicedModel {
  explicit SlicedModel(const GaussianModel& of) : model(of), slicer(of), box(scene_box(of)) {}

  const GaussianModel& model;
  const Slicer slicer;
  const SceneBox box;
};

class SequenceWriter {
 public:
  SequenceWriter(const GaussianModel& model, std::filesystem::path folder,
                 const std::vector<double>& times, const SplatFormat& format,
                 const SequenceHints& hints)
      : model_(model),
        folder_(std::move(folder)),
        times_(times),
        format_(format),
        hints_(hints),
        frames_(times.size()),
        bytes_(times.size()),
        bounds_(times.size()) {}

  /// `time`: of the model.
  void write_frame(size_t i, const SlicedModel& sliced, double time);
  SequenceReport report() const;
  void write_manifest(const SequenceReport& report) const;
  void remove_older_frames() const;

 private:
  std::string name(size_t i) const {
    return sequence_file_name(int64_t(i), int64_t(times_.size()), format_);
  }
  nlohmann::json frames_per_second() const;

  const GaussianModel& model_;  // of windows, what they have in common
  std::filesystem::path folder_;
  const std::vector<double>& times_;
  const SplatFormat& format_;
  const SequenceHints& hints_;
  std::vector<SequenceFrame> frames_;
  std::vector<int64_t> bytes_;
  std::vector<Bounds> bounds_;
};

void SequenceWriter::write_frame(size_t i, const SlicedModel& sliced, double time) {
  const GaussianSet slice = sliced.slicer.at(time);
  const GaussianSpans<const float> values = slice.values();
  SequenceFrame& frame = frames_[i];
  frame.time = times_[i];
  frame.non_finite = sliced.slicer.invalid();
  frame.below_cutoff = sliced.model.count() - sliced.slicer.invalid() - slice.count();
  std::vector<int64_t> rows;
  const Cutoff<float> cutoff = model_.cutoff<float>();
  for (int64_t n = 0; n < slice.count(); ++n) {
    if (!is_valid_element(values, n)) {
      ++frame.non_finite;
    } else if (!cutoff.keeps(sigmoid(*values.at(kOpacityLogit, n)))) {
      ++frame.below_cutoff;
    } else {
      rows.push_back(n);
      const Vec3<float> mean = load3(values.at(kMean, n));
      if (sliced.box.is_far(mean, kFarFactor))
        ++frame.far_outliers;
      else
        bounds_[i].add(mean, mean);
    }
  }
  const std::filesystem::path path = folder_ / name(i);
  frame.out_of_range = save_splat_file(format_, path, select_elements(slice, rows),
                                       {model_.drawing.sh_degree, model_.drawing.filter_2d});
  frame.gaussians = int64_t(rows.size()) - frame.out_of_range;
  bytes_[i] = int64_t(std::filesystem::file_size(path));
}

SequenceReport SequenceWriter::report() const {
  SequenceReport report;
  report.frames = frames_;
  for (size_t i = 0; i < frames_.size(); ++i) {
    report.bytes += bytes_[i];
    report.max_gaussians = std::max(report.max_gaussians, frames_[i].gaussians);
    report.non_finite += frames_[i].non_finite;
    report.below_cutoff += frames_[i].below_cutoff;
    report.far_outliers += frames_[i].far_outliers;
    report.out_of_range += frames_[i].out_of_range;
  }
  return report;
}

/// By the capture's own clock; null for a single frame.
nlohmann::json SequenceWriter::frames_per_second() const {
  const double span = (times_.back() - times_.front()) * model_.time_axis.duration;
  if (!(span > 0)) return nullptr;
  return double(times_.size() - 1) / span;
}

void SequenceWriter::write_manifest(const SequenceReport& report) const {
  nlohmann::json manifest;
  manifest["format"] = fmt::format("3dgs-{}-sequence", format_.name);
  manifest["version"] = 1;
  manifest["count"] = times_.size();
  manifest["fps"] = frames_per_second();
  manifest["time_axis"] = {{"origin", model_.time_axis.origin},
                           {"duration", model_.time_axis.duration}};
  const Similarity& world = model_.prepared_from_source;
  const bool is_source = world.scale == 1 && world.rotation == glm::dmat3(1.0);
  manifest["world"] = is_source ? "source" : "prepared";
  if (is_source && !world.is_identity())  // to be added to all places
    manifest["world_origin"] = {-world.translation.x, -world.translation.y, -world.translation.z};
  manifest["sh_degree"] = model_.drawing.sh_degree;
  manifest["background"] = model_.background;
  manifest["up"] = up_of(hints_.cameras);
  manifest["splat"] = splat_json(model_);
  manifest["cameras"] = nlohmann::json::array();
  for (const PlayerCamera& camera : hints_.cameras)
    manifest["cameras"].push_back(camera_json(camera));
  manifest["constant_ids"] = false;
  manifest["ids"] =
      "row i is not the same Gaussian in each frame: those not drawn at a time are left out";
  Bounds bounds;
  for (const Bounds& frame : bounds_) bounds.add(frame.low, frame.high);
  manifest["bounds"] = bounds.to_json();
  manifest["counters"] = {{"non_finite", report.non_finite},
                          {"below_cutoff", report.below_cutoff},
                          {"far_outliers", report.far_outliers},
                          {"out_of_range", report.out_of_range}};
  manifest["bytes"] = report.bytes;
  for (size_t i = 0; i < frames_.size(); ++i) {
    const SequenceFrame& frame = frames_[i];
    manifest["frames"].push_back(
        {{"file", name(i)},
         {"time", frame.time},
         {"source_time", model_.time_axis.origin + frame.time * model_.time_axis.duration},
         {"gaussians", frame.gaussians},
         {"non_finite", frame.non_finite},
         {"below_cutoff", frame.below_cutoff},
         {"far_outliers", frame.far_outliers},
         {"out_of_range", frame.out_of_range}});
  }
  write_text_file(folder_ / kManifest, json_text(manifest, 2) + "\n");
}

/// The number in frame_0012.EXTENSION of any splat format; nothing for other names.
std::optional<uint64_t> frame_number(const std::string& file) {
  constexpr std::string_view kStart = "frame_";
  if (!file.starts_with(kStart)) return {};
  const size_t end = file.find_first_not_of("0123456789", kStart.size());
  const std::string digits = file.substr(kStart.size(), end - kStart.size());
  const std::vector<SplatFormat>& formats = splat_formats();
  const bool known = end != std::string::npos &&
                     std::any_of(formats.begin(), formats.end(),
                                 [&](const auto& f) { return file.substr(end) == f.extension; });
  if (!known || digits.empty()) return {};
  return digits.size() > 9 ? UINT64_MAX : std::stoull(digits);
}

/// A player takes every frame of a folder: none of another export may stay.
void SequenceWriter::remove_older_frames() const {
  std::vector<std::filesystem::path> stale;
  for (const auto& entry : std::filesystem::directory_iterator(folder_)) {
    const std::string file = entry.path().filename().string();
    const std::optional<uint64_t> number = frame_number(file);
    if (number && (*number >= times_.size() || file != name(size_t(*number))))
      stale.push_back(entry.path());
  }
  for (const auto& path : stale) std::filesystem::remove(path);
}

/// Frames that may be in memory at once: a slice, its selection and the copy that is saved.
int64_t frames_at_once(const GaussianModel& model) {
  constexpr int64_t kBudgetBytes = int64_t(2) << 30, kCopies = 3;
  const int64_t frame = kCopies * std::max<int64_t>(1, model.static_set.value_bytes() +
                                                           model.dynamic_set.value_bytes());
  return std::clamp<int64_t>(kBudgetBytes / frame, 1, thread_count());
}

}  // namespace

std::string sequence_file_name(int64_t i, int64_t count, const SplatFormat& format) {
  const size_t digits = std::max<size_t>(4, std::to_string(count - 1).size());
  return fmt::format("frame_{:0{}}{}", i, digits, format.extension);
}

SequenceReport export_sequence(const GaussianModel& model, const std::filesystem::path& folder,
                               const std::vector<double>& times, const SplatFormat& format,
                               const SequenceProgress& progress, const SequenceHints& hints,
                               const WindowModels& windows) {
  if (times.empty())
    throw InputError(fmt::format("{}: a sequence needs at least one time; pass --frames or --time",
                                 folder.string()));
  for (size_t i = 1; i < times.size(); ++i)
    if (!(times[i] > times[i - 1]))
      throw InputError(
          fmt::format("{}: times of a sequence must ascend, saw {} after {}; sort them",
                      folder.string(), times[i], times[i - 1]));
  make_folder(folder);
  std::filesystem::remove(folder / kManifest);  // it names whole sequences only
  SequenceWriter writer(model, folder, times, format, hints);
  const int64_t count = int64_t(times.size());
  const auto write = [&](const GaussianModel& of, const FileWindow& window, int64_t first,
                         int64_t last) {
    const SlicedModel sliced(of);
    const int64_t at_once = frames_at_once(of);
    for (int64_t begin = first; begin < last; begin += at_once) {
      const int64_t end = std::min(begin + at_once, last);
      parallel_for(end - begin, 1, [&](int64_t k, int64_t) {
        const size_t i = size_t(begin + k);
        writer.write_frame(i, sliced, window_time(window, times[i]));
      });
      if (progress) progress(end, count);
    }
  };
  if (windows.windows.empty()) {
    write(model, FileWindow{}, 0, count);
  } else {
    for (int64_t first = 0, last = 0; first < count; first = last) {
      const int index = window_at(windows.windows, times[size_t(first)]);
      while (last < count && window_at(windows.windows, times[size_t(last)]) == index) ++last;
      write(windows.load(index), windows.windows[size_t(index)], first, last);
    }
  }
  writer.remove_older_frames();
  const SequenceReport report = writer.report();
  writer.write_manifest(report);
  return report;
}

}  // namespace tessera
