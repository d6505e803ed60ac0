// The texel rows of .splatv, sixteen 32-bit words for each Gaussian; a static Gaussian gets a very
// long temporal extent. The format also has cubic motion and rotation, which the Gaussians of
// Tessera do not need.
#include "static3d/formats/splatv.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/packing.hpp>
#include <nlohmann/json.hpp>

#include "ingest/files/atomic_file.h"
#include "ingest/files/bytes.h"
#include "kernels/base/errors.h"
#include "kernels/math/spherical_harmonics.h"
#include "kernels/math/splat.h"
#include "recon4d/evaluation/render.h"
#include "recon4d/model/element_edits.h"
#include "static3d/transform/scene_box.h"
#include "static3d/transform/slicer.h"
#include "static3d/transform/splat_quanta.h"

namespace tessera {
namespace {

constexpr uint32_t kMagic = 0x674b;
constexpr int64_t kTextureWidth = 4096, kTexels = 4;  // texels a row, texels a Gaussian
constexpr int64_t kMostRows = 8192;                   // what WebGL2 gives everywhere
constexpr float kMostHalf = 65504, kLeastHalf = 6.1e-5f;

using Words = std::array<uint32_t, 16>;  // 4 texels of RGBA32UI

/// The values of a row before rounding.
struct SplatvRow {
  Vec3<float> mean{};  // at `centre`, world units
  Vec4<float> rotation{};
  Vec3<float> log_scale{};
  Vec3<float> sh0{};
  float opacity = 0;
  Vec3<float> velocity{};   // world units per unit of normalised time
  float centre = 0;         // normalised time
  float width = kMostHalf;  // falloff exp(−((t − centre)/width)²)
};

uint32_t two_halves(float low, float high) {
  return glm::packHalf2x16(
      {std::clamp(low, -kMostHalf, kMostHalf), std::clamp(high, -kMostHalf, kMostHalf)});
}

float half_of(float value) {
  return glm::unpackHalf2x16(two_halves(value, 0)).x;
}

uint32_t colour_word(const SplatvRow& row) {
  uint32_t word = uint32_t(byte_of(255 * double(row.opacity))) << 24;
  for (int c = 0; c < 3; ++c)
    word |= uint32_t(byte_of(255 * (0.5 + kSh0 * double(row.sh0[c])))) << (8 * c);
  return word;
}

/// The mean is given where the rounded centre is, so that rounding time moves nothing.
Words words_of(const SplatvRow& row) {
  const float centre = half_of(row.centre);
  const Vec3<float> mean = row.mean + row.velocity * (centre - row.centre);
  Words words{};
  for (int k = 0; k < 3; ++k) std::memcpy(&words[size_t(k)], &mean[k], sizeof(float));
  const Vec4<float>& q = row.rotation;
  words[3] = two_halves(q[0], q[1]);
  words[4] = two_halves(q[2], q[3]);
  words[5] = two_halves(std::exp(row.log_scale[0]), std::exp(row.log_scale[1]));
  words[6] = two_halves(std::exp(row.log_scale[2]), 0);
  words[7] = colour_word(row);
  words[8] = two_halves(row.velocity[0], row.velocity[1]);
  words[9] = two_halves(row.velocity[2], 0);  // 9 to 14: motion of higher order, turning
  words[15] = two_halves(centre, std::clamp(row.width, kLeastHalf, kMostHalf));
  return words;
}

/// What fills the last row of the texture: long gone at any timestep of the clip.
Words nothing() {
  Words words{};
  words[3] = two_halves(1, 0);
  words[15] = two_halves(-1000, 1);
  return words;
}

SplatvRow still_row(const GaussianSpans<const float>& set, int64_t n) {
  SplatvRow row;
  const float* const q = set.at(kRotation, n);
  const float norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  row.rotation = Vec4<float>(q[0], q[1], q[2], q[3]) * (1 / norm);
  for (int k = 0; k < 3; ++k) {
    row.mean[k] = set.at(kMean, n)[k];
    row.log_scale[k] = set.at(kLogScale, n)[k];
    row.sh0[k] = set.at(kSh, n)[k];
  }
  row.opacity = sigmoid(*set.at(kOpacityLogit, n));
  return row;
}

/// The timestep of the clip at which it is brightest.
float brightest(const MovingGaussian& g) {
  return std::clamp(g.spacetime.mean_time, 0.0f, 1.0f);
}

SplatvRow moving_row(const GaussianModel& model, const MovingGaussian& g) {
  const GaussianSpans<const float> set = model.dynamic_set.values();
  SplatvRow row;
  row.mean = g.mean;
  row.rotation = g.rotation;
  row.log_scale = g.log_scale;
  row.opacity = g.opacity;
  row.velocity = g.spacetime.velocity;
  row.centre = g.spacetime.mean_time;
  // p = exp(−½Δ²/(w + f)), f of the temporal filter
  const double variance = 1 / double(g.spacetime.precision_time) + model.drawing.time_filter;
  row.width = float(std::min(std::sqrt(2 * variance), double(kMostHalf)));
  ColourRules<float> colours =
      make_colour_rules<float>(render_options(model), set.coefficients, set.time_levels);
  colours.degree = 0;
  for (int c = 0; c < 3; ++c) row.sh0[c] = set.at(kSh, g.source)[c];
  add_levels(colours, brightest(g) - row.centre, set.at(kShTime, g.source), &row.sh0[0]);
  return row;
}

bool is_ever_drawn(const GaussianModel& model, const MovingGaussian& g) {
  const Slice<float> slice =
      slice_at(g.mean, g.spacetime, brightest(g), float(model.drawing.time_filter));
  return slice.marginal >= kMinMarginal<float> &&
         model.cutoff<float>().keeps(g.opacity * slice.marginal);
}

std::string texture_of(const GaussianModel& model, SplatvReport& report) {
  std::string texture;
  const auto add = [&](const SplatvRow& row) {
    for (const uint32_t word : words_of(row)) append(texture, word);
    ++report.gaussians;
  };
  const GaussianSpans<const float> fixed = model.static_set.values();
  for (const int64_t n : valid_elements(model.static_set)) add(still_row(fixed, n));
  report.non_finite = model.static_set.count() - report.gaussians;
  const Slicer slicer(model);
  report.non_finite += slicer.invalid();
  const GaussianSpans<const float> dynamic = model.dynamic_set.values();
  for (const MovingGaussian& g : slicer.moving()) {
    if (!is_valid_element(dynamic, g.source))
      ++report.non_finite;  // its colour
    else if (!is_ever_drawn(model, g))
      ++report.never_drawn;
    else
      add(moving_row(model, g));
  }
  return texture;
}

/// Position and axes in the world, z forward, one row a line.
nlohmann::json camera_json(size_t id, const PlayerCamera& named) {
  const Camera& camera = named.camera;
  const glm::dvec3 eye = camera.position();
  nlohmann::json rotation = nlohmann::json::array();
  for (int row = 0; row < 3; ++row)  // world from camera
    rotation.push_back({camera.cam_from_world[row][0], camera.cam_from_world[row][1],
                        camera.cam_from_world[row][2]});
  return {{"id", id},
          {"img_name", named.name},
          {"width", camera.width},
          {"height", camera.height},
          {"position", {eye.x, eye.y, eye.z}},
          {"rotation", rotation},
          {"fx", camera.fl_x},
          {"fy", camera.fl_y}};
}

}  // namespace

PlayerCamera splatv_camera(const GaussianModel& model) {
  constexpr int kWidth = 1280, kHeight = 720;
  constexpr double kFocal = 1000, kDistance = 4;  // pixels; × the scene's half extent
  const SceneBox box = scene_box(model);
  Camera camera;
  camera.width = kWidth;
  camera.height = kHeight;
  camera.fl_x = camera.fl_y = kFocal;
  camera.cx = kWidth / 2.0;
  camera.cy = kHeight / 2.0;
  const double back = kDistance * (box.half_extent > 0 ? double(box.half_extent) : 1.0);
  camera.translation = glm::dvec3(0, 0, back) - glm::dvec3(box.centre);
  return {"front", camera};
}

SplatvReport save_splatv(const std::filesystem::path& path, const GaussianModel& model,
                         const std::vector<PlayerCamera>& cameras) {
  check(!cameras.empty(), "save_splatv: a camera, splatv_camera makes one");
  if (!model.nodes.empty())
    throw InputError(fmt::format(
        "{}: .splatv holds Gaussians that move by themselves, this model has motion nodes; export "
        "frames as ply",
        path.string()));
  SplatvReport report;
  std::string texture = texture_of(model, report);
  constexpr int64_t kPerRow = kTextureWidth / kTexels;
  const int64_t rows = std::max<int64_t>(1, (report.gaussians + kPerRow - 1) / kPerRow);
  if (rows > kMostRows)
    throw InputError(fmt::format("{}: .splatv holds {} Gaussians, the model has {}; export as ply",
                                 path.string(), kMostRows * kPerRow, report.gaussians));
  for (int64_t n = report.gaussians; n < rows * kPerRow; ++n)
    for (const uint32_t word : nothing()) append(texture, word);
  nlohmann::json list = nlohmann::json::array();
  for (size_t i = 0; i < cameras.size(); ++i) list.push_back(camera_json(i, cameras[i]));
  const nlohmann::json chunk = {{"type", "splat"},
                                {"size", texture.size()},
                                {"texwidth", kTextureWidth},
                                {"texheight", rows},
                                {"cameras", list}};
  const std::string text = nlohmann::json::array({chunk}).dump();
  std::string file;
  append(file, kMagic);
  append(file, uint32_t(text.size()));
  file += text;
  file += texture;
  write_text_file(path, file);
  report.bytes = int64_t(file.size());
  return report;
}

}  // namespace tessera
