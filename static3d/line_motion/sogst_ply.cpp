// The interchange PLY of .sogst: seconds of the clip, σ_t itself, quaternions w first, all 45
// f_rest or none. Source: "The .sogst format", revision 14 (CC BY 4.0), section 7.
#include <fmt/format.h>

#include <algorithm>

#include "ingest/files/json_file.h"
#include "static3d/line_motion/line_columns.h"
#include "static3d/line_motion/line_formats.h"
#include "static3d/line_motion/lines.h"
#include "static3d/line_motion/model_notes.h"
#include "static3d/line_motion/seconds.h"

namespace tessera {
namespace {

const std::vector<ForeignName>& sogst_names() {
  static const std::vector<ForeignName> rows{{"t_center", "mean_time"},
                                             {"t_sigma", "scale_time"},
                                             {"vx", "velocity_0"},
                                             {"vy", "velocity_1"},
                                             {"vz", "velocity_2"}};
  return rows;
}

/// In the order of the specification.
std::vector<SplatColumn> sogst_columns(int coefficients) {
  constexpr const char* kOrder[] = {"x",       "y",      "z",        "rot_0",   "rot_1",
                                    "rot_2",   "rot_3",  "scale_0",  "scale_1", "scale_2",
                                    "opacity", "f_dc_0", "f_dc_1",   "f_dc_2",  "vx",
                                    "vy",      "vz",     "t_center", "t_sigma"};
  const auto place_of = [&](const SplatColumn& column) {
    return std::find(std::begin(kOrder), std::end(kOrder), column.name) - std::begin(kOrder);
  };
  std::vector<SplatColumn> columns = line_columns(sogst_names(), coefficients);
  std::stable_sort(columns.begin(), columns.end(), [&](const SplatColumn& a, const SplatColumn& b) {
    return place_of(a) < place_of(b);
  });
  return columns;
}

/// The scalars of the clip: of the sidecar where there is one, else of the comments.
ModelNotes clip_scalars(const std::filesystem::path& path, const PlyFile& file) {
  std::filesystem::path sidecar = path;
  if (sidecar.extension() == ".ply") sidecar.replace_extension();
  sidecar += ".sogst.json";
  ModelNotes scalars;
  if (std::filesystem::exists(sidecar)) {
    const nlohmann::json stated = read_json(sidecar);
    for (const char* key : {"time_min", "time_max"})
      if (stated.is_object() && stated.contains(key) && stated[key].is_number())
        scalars[key] = stated[key].get<double>();
  }
  for (const char* key : {"time_min", "time_max"})
    if (!scalars.contains(key))
      scalars[key] = required_number(path, file, fmt::format("sogst.{}", key));
  return scalars;
}

}  // namespace

int64_t save_sogst_ply(const std::filesystem::path& path, const GaussianModel& model, double fps) {
  GaussianSet lines = lines_of(model, drawn_degree(model) > 0 ? kMaxShDegree : 0, kLongLife);
  const TimeAxis& axis = model.time_axis;
  to_seconds(axis, lines);
  std::vector<std::string> comments{
      "sogst.version 1", fmt::format("sogst.time_min {}", axis.origin),
      fmt::format("sogst.time_max {}", axis.origin + axis.duration),
      fmt::format("sogst.fps {}", fps > 0 ? fps : kUnstatedRate), "sogst.motion_degree 1"};
  for (std::string& note : comments_of(notes_of(model))) comments.push_back(std::move(note));
  write_splats(path, comments,
               {{"vertex", &lines, lines.coefficients(), sogst_columns(lines.coefficients())}});
  return 0;
}

LineFile load_sogst_ply(const std::filesystem::path& path, const PlyFile& file) {
  const ModelNotes scalars = clip_scalars(path, file);
  const double origin = scalars.at("time_min");
  const TimeAxis axis{origin, scalars.at("time_max") - origin};
  GaussianSet lines = read_lines(path, file, sogst_names());
  from_seconds(path.string(), axis, lines);
  GaussianModel model = model_of_lines(lines, axis);
  take_notes(notes_in(file.comments), path.string(), model);
  model.time_axis = axis;
  return {std::move(model), {}};
}

}  // namespace tessera
