// One window after another is read, moved to the world of the capture, and written.
#include "tools/export/windows_export.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "ingest/files/atomic_file.h"
#include "kernels/base/errors.h"
#include "recon4d/model/model_file.h"
#include "static3d/tessera4d/windowed_file.h"
#include "static3d/transform/world_change.h"
#include "tools/cli/interrupt.h"
#include "tools/cli/terminal.h"
#include "tools/export/player_files.h"
#include "tools/session/output_folder.h"
#include "tools/session/run_folder.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

GaussianModel in_world(GaussianModel model, bool keep_world) {
  return keep_world ? std::move(model) : model_in_source_world(model);
}

GaussianModel exported_model(const fs::path& run, bool keep_world) {
  return in_world(load_model(RunFolder{run}.model()), keep_world);
}

class WindowsExport {
 public:
  WindowsExport(const ExportRequest& request, const WindowsFolder& folder)
      : request_(request), folder_(folder), plan_(folder.read()) {
    check_request();
    require_all_windows(folder_, plan_);
  }

  json write() {
    json written = find_time_format(request_.format) == nullptr ? write_frames() : write_in_time();
    written["windows"] = plan_.windows.size();
    return written;
  }

 private:
  /// Numbered files, each of the window that is drawn at its time.
  json write_frames() {
    ClipModels clip = clip_models(folder_);
    const bool keep_world = request_.keep_world;
    clip.head = in_world(std::move(clip.head), keep_world);
    clip.windows.load = [keep_world, load = std::move(clip.windows.load)](int window) {
      return in_world(load(window), keep_world);
    };
    ExportRequest frames = request_;
    frames.model = folder_.window_run(clip.head_window).string();
    json written = export_frames(frames, clip.head, clip.windows);
    written["peak_gaussians"] = written["max_gaussians"];
    return written;
  }

  json write_in_time() {
    GaussianModel fixed = exported_model(folder_.static_run(), request_.keep_world);
    fixed.time_axis = plan_.clip;
    const bool page = request_.format == "page" || request_.format == "html";
    const PageHead head = page ? head_of_first() : PageHead{};
    OutputFolder output(request_.out, "export", {}, request_.overwrite);
    const fs::path blocks = request_.single || request_.format == "html"
                                ? output.staging() / ".blocks"
                                : output.staging();
    const Tessera4dWritten written = output.written([&] { return write_file(blocks, fixed); });
    int64_t bytes = 0, files = 0;
    if (blocks == output.staging()) {
      list_files(output, bytes, files);
      if (page) add(output, kPageFile, page_of_folder(head), bytes, files);
      if (const std::string poster = head.poster.file(); !poster.empty())
        add(output, poster, head.poster.bytes, bytes, files);
      if (const std::string sound = fs::path(request_.audio).filename().string(); !sound.empty())
        add(output, sound, read_text_file(request_.audio), bytes, files);
    } else {
      const fs::path single = output.path(kSingleTessera4d);
      single_from_folder(blocks, single);
      fs::remove_all(blocks);
      if (page) {
        add(output, kPageFile, page_with(read_text_file(single), head), bytes, files);
        fs::remove(single);
      } else {
        output.add(kSingleTessera4d);
        bytes += int64_t(fs::file_size(single));
        ++files;
      }
    }
    output.finish();
    return {{"frames", files},
            {"bytes", bytes},
            {"scene_bytes", written.bytes},
            {"max_gaussians", written.static_count + written.dynamic_count},
            {"peak_gaussians", written.peak},
            {"non_finite", written.non_finite},
            {"never_drawn", written.never_drawn},
            {"far_outliers", written.far_outliers}};
  }

  void check_request() const {
    const TimeFormat* const format = find_time_format(request_.format);
    if (format != nullptr && !format->is_tessera4d)
      throw InputError(fmt::format(
          "export: {} holds {} windows, and --format {} one model; name the run of a window, e.g. "
          "{}, or take --format tessera, page, html or frames (ply, spz, …)",
          request_.model, plan_.windows.size(), request_.format, folder_.window_run(0).string()));
    for (const auto& [given, name] :
         {std::pair{request_.truth, "--truth"}, {request_.clean.value_or(false), "--clean"}})
      if (given)
        throw InputError(
            fmt::format("export: {} is of one model, and {} holds {} windows; leave "
                        "it out",
                        name, request_.model, plan_.windows.size()));
  }

  /// Its poster is drawn from the first window.
  PageHead head_of_first() const {
    ExportRequest first = request_;
    first.model = folder_.window_run(0).string();
    first.truth = false;
    return page_head(first, exported_model(folder_.window_run(0), request_.keep_world));
  }

  Tessera4dOptions options_of(const GaussianModel& fixed) const {
    ExportRequest whole = request_;
    if (whole.cameras.empty()) whole.cameras = scene_of_windows(folder_, plan_).string();
    return tessera4d_options(whole, fixed);
  }

  Tessera4dWritten write_file(const fs::path& blocks, const GaussianModel& fixed) {
    const auto count = int64_t(plan_.windows.size());
    for (int64_t i = 0; i < count; ++i)
      plan_.windows[size_t(i)].light =
          RunFolder{folder_.window_run(i)}.read_config().value("light", kSameLight);
    WindowedWriter writer(blocks, fixed, plan_.clip, plan_.windows, options_of(fixed));
    ProgressBar bar("export");
    for (int64_t i = 0; i < count; ++i) {
      stop_if_interrupted();
      writer.add(int(i), exported_model(folder_.window_run(i), request_.keep_world));
      bar.update(i + 1, count, "windows");
    }
    return writer.finish();
  }

  static void list_files(OutputFolder& output, int64_t& bytes, int64_t& files) {
    std::vector<std::string> names;
    for (const fs::directory_entry& entry : fs::directory_iterator(output.staging()))
      names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    for (const std::string& name : names) {
      output.add(name);
      bytes += int64_t(fs::file_size(output.path(name)));
      ++files;
    }
  }
  static void add(OutputFolder& output, const std::string& name, const std::string& content,
                  int64_t& bytes, int64_t& files) {
    write_text_file(output.path(name), content);
    output.add(name);
    bytes += int64_t(content.size());
    ++files;
  }

  const ExportRequest& request_;
  const WindowsFolder& folder_;
  WindowsPlan plan_;
};

}  // namespace

json export_windows(const ExportRequest& request, const WindowsFolder& folder) {
  return WindowsExport(request, folder).write();
}

}  // namespace tessera
