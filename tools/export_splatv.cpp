// What: the folder, the cameras and the report of one .splatv.
// Not: arguments (cmd_export.cpp).
#include "tools/export_splatv.h"

#include <nlohmann/json.hpp>

#include "static3d/splatv.h"
#include "tools/output_folder.h"
#include "tools/rig_cameras.h"

namespace tessera {

nlohmann::json write_splatv(const ExportRequest& request, GaussianModel& model) {
  constexpr const char* kFile = "model.splatv";
  std::vector<PlayerCamera> cameras = rig_of(request.cameras, request.model, model).cameras;
  if (cameras.empty()) cameras.push_back(splatv_camera(model));
  OutputFolder folder(request.out, "export", {kFile}, request.overwrite);
  const SplatvReport report = save_splatv(folder.path(kFile), model, cameras);
  folder.finish();
  return {{"frames", 1},
          {"bytes", report.bytes},
          {"max_gaussians", report.gaussians},
          {"non_finite", report.non_finite},
          {"never_drawn", report.never_drawn}};
}

}  // namespace tessera
