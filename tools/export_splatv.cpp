// What: the folder and the report of one .splatv.
// Not: arguments (cmd_export.cpp).
#include "tools/export_splatv.h"

#include "static3d/splatv.h"
#include "tools/output_folder.h"

namespace tessera {

nlohmann::json export_splatv(const std::filesystem::path& folder, const GaussianModel& model,
                             bool overwrite) {
  OutputFolder output(folder, "export", {"model.splatv"}, overwrite);
  const SplatvReport report =
      save_splatv(output.path("model.splatv"), model, {splatv_camera(model)});
  output.finish();
  return {{"frames", 1},
          {"bytes", report.bytes},
          {"max_gaussians", report.gaussians},
          {"non_finite", report.non_finite},
          {"below_cutoff", report.never_seen}};
}

}  // namespace tessera
