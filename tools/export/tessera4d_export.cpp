// Blocks are written to a hidden folder first, block by block.
#include "tools/export/tessera4d_export.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "ingest/files/atomic_file.h"
#include "static3d/tessera4d/windowed_file.h"
#include "tools/cli/interrupt.h"
#include "tools/cli/terminal.h"
#include "tools/export/page_head.h"
#include "tools/export/player_files.h"
#include "tools/session/output_folder.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

Tessera4dWritten write_windows(const fs::path& folder, const Clip& clip,
                               const Tessera4dOptions& options) {
  WindowedWriter writer(folder, clip.load_static(), clip.head->time_axis, clip.windows.windows,
                        options);
  ProgressBar bar("export");
  for (int64_t i = 0; i < clip.count(); ++i) {
    stop_if_interrupted();
    writer.add(int(i), clip.windows.load(int(i)));
    bar.update(i + 1, clip.count(), "windows");
  }
  return writer.finish();
}

/// Manifest and blocks.
Tessera4dWritten write_blocks(const ExportRequest& request, const fs::path& folder,
                              const Clip& clip) {
  const Tessera4dOptions options = tessera4d_options(request, *clip.head);
  if (clip.count() > 1) return write_windows(folder, clip, options);
  const Tessera4dFile file = encode_tessera4d(*clip.head, options);
  write_tessera4d_folder(folder, file);
  return {file, file.static_count + file.dynamic_count, file.bytes()};
}

/// An output folder whose files are counted.
class CountedOutput {
 public:
  explicit CountedOutput(const ExportRequest& request)
      : output_(request.out, "export", {}, request.overwrite) {}

  const fs::path& staging() const { return output_.staging(); }
  /// A file that lies in `staging`.
  void take(const std::string& name) {
    output_.add(name);
    bytes_ += int64_t(fs::file_size(output_.path(name)));
    ++files_;
  }
  void add(const std::string& name, const std::string& content) {
    if (name.empty()) return;
    write_text_file(output_.path(name), content);
    take(name);
  }
  template <class Write>
  auto written(const Write& write) const {
    return output_.written(write);
  }
  json finish() {
    output_.finish();
    return {{"frames", files_}, {"bytes", bytes_}};
  }

 private:
  OutputFolder output_;
  int64_t bytes_ = 0, files_ = 0;
};

void take_blocks(CountedOutput& output) {
  std::vector<std::string> names;
  for (const fs::directory_entry& entry : fs::directory_iterator(output.staging()))
    names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  for (const std::string& name : names) output.take(name);
}

}  // namespace

json export_tessera4d(const ExportRequest& request, Clip& clip) {
  const bool html = request.format == "html", page = html || request.format == "page";
  const bool one_file = html || request.single;
  const PageHead head = page ? page_head(request, *clip.head) : PageHead{};
  const std::string sound = request.audio.empty() ? "" : read_text_file(request.audio);
  CountedOutput output(request);
  const fs::path blocks = one_file ? output.staging() / ".blocks" : output.staging();
  if (one_file) fs::create_directory(blocks);
  const Tessera4dWritten written =
      output.written([&] { return write_blocks(request, blocks, clip); });
  if (one_file) {
    const fs::path single = output.staging() / kSingleTessera4d;
    single_from_folder(blocks, single);
    fs::remove_all(blocks);
    if (html) {
      output.add(kPageFile, page_with(read_text_file(single), head));
      fs::remove(single);
    } else {
      output.take(kSingleTessera4d);
    }
  } else {
    take_blocks(output);
    if (page) output.add(kPageFile, page_of_folder(head));
    output.add(head.poster.file(), head.poster.bytes);
    output.add(fs::path(request.audio).filename().string(), sound);
  }
  json result = output.finish();
  result.update({{"scene_bytes", written.bytes},
                 {"max_gaussians", written.static_count + written.dynamic_count},
                 {"non_finite", written.non_finite},
                 {"never_drawn", written.never_drawn},
                 {"far_outliers", written.far_outliers}});
  if (clip.count() > 1)
    result.update({{"windows", clip.count()}, {"peak_gaussians", written.peak}});
  return result;
}

}  // namespace tessera
