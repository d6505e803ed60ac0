// FTGS PLY, version 1, of FreeTimeGsVanilla and ftgs-player: normalised time, ln σ_t, quaternions w
// first. α = max(σ(o)·exp(−½ (dt / max(σ_t, min_duration))²), opacity_floor): neither bound acts in
// what is written. Source: "FTGS PLY, version 1" of ftgs-player.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "kernels/base/errors.h"
#include "static3d/line_motion/line_columns.h"
#include "static3d/line_motion/line_formats.h"
#include "static3d/line_motion/lines.h"
#include "static3d/line_motion/model_notes.h"

namespace tessera {
namespace {

const std::vector<ForeignName>& ftgs_names() {
  static const std::vector<ForeignName> rows{{"time", "mean_time"}, {"log_duration", "scale_time"}};
  return rows;
}

/// Normals follow the position, as in the .ply of 3DGS.
std::vector<SplatColumn> ftgs_columns(int coefficients) {
  std::vector<SplatColumn> columns = line_columns(ftgs_names(), coefficients);
  const std::vector<SplatColumn> normals{
      {"nx", std::nullopt, 0}, {"ny", std::nullopt, 0}, {"nz", std::nullopt, 0}};
  columns.insert(columns.begin() + 3, normals.begin(), normals.end());
  return columns;
}

}  // namespace

int64_t save_ftgs_ply(const std::filesystem::path& path, const GaussianModel& model, double fps) {
  const GaussianSet lines = lines_of(model, drawn_degree(model), kLongLife);
  float shortest = 0;
  for (const float log_scale : lines.group(kLogScaleTime).value.span())
    shortest = std::min(shortest, log_scale);
  std::vector<std::string> comments{
      "ftgs_version 1",
      "time_units normalized",
      fmt::format("sh_degree {}", sh_degree_of(lines.coefficients())),
      "use_velocity 1",
      fmt::format("min_duration {}", 0.5 * std::exp(double(shortest))),
      "opacity_floor 0"};
  if (fps > 0)
    comments.push_back(
        fmt::format("n_frames {}", 1 + std::llround(model.time_axis.duration * fps)));
  for (std::string& note : comments_of(notes_of(model))) comments.push_back(std::move(note));
  write_splats(path, comments,
               {{"vertex", &lines, lines.coefficients(), ftgs_columns(lines.coefficients())}});
  return 0;
}

LineFile load_ftgs_ply(const std::filesystem::path& path, const PlyFile& file) {
  if (const double version = required_number(path, file, "ftgs_version"); version != 1)
    throw InputError(
        fmt::format("{}: FTGS PLY of version {}, this program reads 1", path.string(), version));
  GaussianSet lines = read_lines(path, file, ftgs_names());
  const double shortest = required_number(path, file, "min_duration");
  if (!(shortest > 0))
    throw InputError(fmt::format("{}: min_duration {}, expected more than 0; export it again",
                                 path.string(), shortest));
  const bool moves = required_number(path, file, "use_velocity") != 0;
  const GaussianSpans<float> values = lines.values();
  for (int64_t n = 0; n < lines.count(); ++n) {
    float& extent = *values.at(kLogScaleTime, n);
    extent = std::max(extent, float(std::log(shortest)));
    if (!moves) std::fill_n(values.at(kVelocity, n), 3, 0.0f);
  }
  const std::vector<double> stated = comment_numbers(path, file.comments, "n_frames", 1);
  const double frames = stated.empty() ? kUnstatedFrames : stated[0];
  GaussianModel model =
      model_of_lines(lines, {0, std::max(frames - 1, 1.0) / kUnstatedRate, false});
  take_notes(notes_in(file.comments), path.string(), model);
  return {std::move(model), {}};
}

}  // namespace tessera
