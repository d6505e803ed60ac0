// Brings the clip to lines, and saves them.
#include "tools/export/line_export.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "kernels/base/counted.h"
#include "static3d/line_motion/line_model.h"
#include "tools/camera_paths/camera_views.h"
#include "tools/cli/terminal.h"
#include "tools/session/output_folder.h"

namespace tessera {

std::filesystem::path line_file_of(const std::filesystem::path& folder, const LineFormat& format) {
  return folder / (std::string("scene") + format.extension);
}

nlohmann::json export_lines(const ExportRequest& request, Clip& clip) {
  const LineFormat& format = *find_line_format(request.format);
  const std::string name = line_file_of("", format).string();
  OutputFolder folder(request.out, "export", {name}, request.overwrite);
  const GaussianModel still = clip.count() > 1 ? clip.load_static() : clip.head->clone_values();
  const GaussianModel model = line_model(clip.windows, still);
  const double fps =
      request.times.fps.value_or(rig_of(request.cameras, request.model, *clip.head).fps);
  const int64_t far = format.save(folder.path(name), model, fps);
  const auto bytes = std::filesystem::file_size(folder.path(name));
  folder.finish();
  if (far > 0)
    warn(
        fmt::format("{}: {} left out: too far from the others for the range of "
                    "--format {}; ftgs keeps them",
                    request.out, counted(far, "Gaussian"), request.format));
  nlohmann::json result = {
      {"frames", 1}, {"bytes", bytes}, {"max_gaussians", model.count()}, {"out_of_range", far}};
  if (clip.count() > 1)
    result.update({{"windows", clip.count()}, {"peak_gaussians", model.count()}});
  return result;
}

}  // namespace tessera
