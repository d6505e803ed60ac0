// What: the folder, the cameras and the report of one .splatv.
// Not: arguments (commands/export.cpp).
#include "tools/export/splatv.h"

#include <nlohmann/json.hpp>

#include "static3d/formats/splatv.h"
#include "tools/camera_paths/rig_cameras.h"
#include "tools/export/output_folder.h"

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
