// Writes the JSON text, sampled points and their PLY, and joins masks over the timesteps of a clip.
#include "tools/synth/ground_truth.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "ingest/files/ply.h"
#include "tools/synth/hash.h"
#include "tools/synth/render.h"
#include "tools/synth/rigs.h"
#include "tools/synth/sensor.h"

namespace tessera::synth {
namespace {

using nlohmann::ordered_json;

ordered_json options_json(const SynthOptions& options) {
  ordered_json object{{"scene", name_of(options.scene)},
                      {"layout", name_of(options.layout)},
                      {"cameras", options.cameras},
                      {"frames", options.frames},
                      {"held_out_frames", options.held_out_frames},
                      {"width", options.width},
                      {"height", options.height},
                      {"fps", {options.fps.numerator, options.fps.denominator}},
                      {"seed", options.seed},
                      {"supersampling", options.supersampling},
                      {"specular", options.specular},
                      {"video_quality", options.video_quality},
                      {"noise_sigma", options.noise_sigma},
                      {"exposure_wobble", options.exposure_wobble},
                      {"light_step", options.light_step},
                      {"camera_gains", options.camera_gains},
                      {"moving_share", options.moving_share},
                      {"points", options.points}};
  if (!options.shifts.empty()) object["shifts"] = options.shifts;
  if (!options.readouts.empty()) object["readouts"] = options.readouts;
  if (options.repeat > 0) object["repeat"] = options.repeat;
  return object;
}

/// Solids that are there only for a while, with the frames that show them.
ordered_json appearing_json(const SynthOptions& options, const World& world) {
  ordered_json list = ordered_json::array();
  for (const Solid& solid : world.solids) {
    if (solid.lifetime.whole_clip()) continue;
    ordered_json shown = ordered_json::array();
    for (int frame = 0; frame < options.frames; ++frame)
      if (solid.lifetime.contains(world_time(options, frame))) shown.push_back(frame);
    const Lifetime& life = solid.lifetime;
    list.push_back({{"name", solid.name},
                    {"begin", life.begin},  // there for begin <= time < end
                    {"end", life.end},
                    {"begin_seconds", seconds(options, life.begin)},
                    {"end_seconds", seconds(options, life.end)},
                    {"frames", shown}});
  }
  return list;
}

/// [x0, y0, x1, y1] a frame, the latter two exclusive, or null.
ordered_json boxes_json(const TrueView& view) {
  ordered_json object = ordered_json::object();
  for (const auto& [name, boxes] : view.boxes) {
    ordered_json list = ordered_json::array();
    for (const PixelBox& box : boxes)
      list.push_back(box.empty() ? ordered_json(nullptr)
                                 : ordered_json{box.x0, box.y0, box.x1, box.y1});
    object[name] = std::move(list);
  }
  return object;
}

ordered_json views_json(const SynthOptions& options, const std::vector<TrueView>& views) {
  ordered_json list = ordered_json::array();
  for (int number = 0; const TrueView& view : views) {
    ordered_json row{{"name", view.name}, {"transform_matrix", opengl_pose(view.camera)}};
    if (!view.split.empty()) {
      row["split"] = view.split;
      row["index"] = view.index;
      row["time"] = view.time;
      row["seconds"] = seconds(options, view.time);
    }
    if (options.camera_gains) row["gain"] = camera_gain(options, number);
    const double frame = double(options.fps.denominator) / options.fps.numerator;
    if (const double shift = shift_of(options, number); shift != 0) {
      row["shift_frames"] = shift;  // frame k shows instant k + shift
      row["shift_seconds"] = shift * frame;
    }
    if (const double readout = readout_of(options, number); readout != 0)
      row["readout_seconds"] = readout * frame;
    ++number;
    if (view.split.empty()) row["boxes"] = boxes_json(view);
    list.push_back(std::move(row));
  }
  return list;
}

}  // namespace

double normalised_time(const SynthOptions& options, double frame) {
  return options.frames > 1 ? frame / (options.frames - 1) : 0;
}

double world_time(const SynthOptions& options, double frame) {
  if (options.repeat < 2) return normalised_time(options, frame);
  const double phase = std::fmod(std::abs(frame) / (options.repeat - 1), 2.0);
  return phase <= 1 ? phase : 2 - phase;
}

double shift_of(const SynthOptions& options, int camera) {
  return size_t(camera) < options.shifts.size() ? options.shifts[size_t(camera)] : 0;
}

double readout_of(const SynthOptions& options, int camera) {
  return size_t(camera) < options.readouts.size() ? options.readouts[size_t(camera)] : 0;
}

double seconds(const SynthOptions& options, double normalised) {
  return normalised * (options.frames - 1) * options.fps.denominator / options.fps.numerator;
}

std::string truth_json(const SynthOptions& options, const World& world,
                       const std::vector<TrueView>& views) {
  const Camera& camera = views.front().camera;  // all views share their intrinsics
  ordered_json times = ordered_json::array(), times_seconds = ordered_json::array();
  for (int frame = 0; frame < options.frames; ++frame) {
    times.push_back(normalised_time(options, frame));
    times_seconds.push_back(seconds(options, times.back().get<double>()));
  }
  const ordered_json truth{{"written_by", "tessera synth"},
                           {"version", 1},
                           {"scene", name_of(options.scene)},
                           {"seed", options.seed},
                           {"options", options_json(options)},
                           {"fps", {options.fps.numerator, options.fps.denominator}},
                           {"frames", options.frames},
                           {"times", times},
                           {"times_seconds", times_seconds},
                           {"intrinsics",
                            {{"w", camera.width},
                             {"h", camera.height},
                             {"fl_x", camera.fl_x},
                             {"fl_y", camera.fl_y},
                             {"cx", camera.cx},
                             {"cy", camera.cy}}},
                           {"axes", "camera to world, OpenGL: x right, y up, z backward"},
                           {"cameras", views_json(options, views)},
                           {"appearing", appearing_json(options, world)}};
  return truth.dump(1) + "\n";
}

PointCloud sample_static_points(const World& world, const std::vector<TrueView>& views, int count,
                                uint64_t seed) {
  const std::vector<PlacedSolid> solids = place(world, Part::kStatic, 0);
  const uint32_t base = hash(uint32_t(seed), int64_t(seed >> 32), 9);
  PointCloud points;
  for (int64_t attempt = 0; attempt < 20LL * count; ++attempt) {
    if (int64_t(points.position.size()) == count) break;
    const uint32_t h = hash(base, attempt);
    const Camera& camera = views[size_t(h % uint32_t(views.size()))].camera;
    const Ray ray =
        pixel_ray(camera, camera.width * unit(mix(h)), camera.height * unit(mix(h + 1)));
    const Meeting meeting = cast(ray, solids);
    if (meeting.placed == nullptr) continue;
    points.position.emplace_back(ray.origin + meeting.hit.depth * ray.direction);
    const glm::vec3 colour = 255.f * shade(world.light, ray, meeting, solids);
    points.colour.push_back({uint8_t(std::lround(colour.r)), uint8_t(std::lround(colour.g)),
                             uint8_t(std::lround(colour.b))});
  }
  return points;
}

void write_points(const std::filesystem::path& path, const PointCloud& points) {
  PlyElement vertex{"vertex", int64_t(points.position.size()), {}};
  const char* axes[] = {"x", "y", "z"};
  const char* channels[] = {"red", "green", "blue"};
  for (int k = 0; k < 3; ++k) {
    PlyColumn column{axes[k], PlyType::kFloat32, {}};
    for (const glm::vec3& p : points.position) column.values.push_back(p[k]);
    vertex.columns.push_back(std::move(column));
  }
  for (size_t k = 0; k < 3; ++k) {
    PlyColumn column{channels[k], PlyType::kUint8, {}};
    for (const auto& colour : points.colour) column.values.push_back(colour[k]);
    vertex.columns.push_back(std::move(column));
  }
  write_ply(path, {{"static surface points, tessera synth"}, {vertex}});
}

std::vector<uint8_t> ever_covered(const World& world, const Camera& camera,
                                  const std::vector<double>& times, const StaticLayer& layer) {
  std::vector<uint8_t> ever(size_t(camera.width) * size_t(camera.height));
  for (const double time : times) {
    const std::vector<float> share = render(world, camera, time, layer).moving_share;
    for (size_t p = 0; p < ever.size(); ++p) ever[p] |= uint8_t(share[p] > 0);
  }
  return ever;
}

Image8 moving_image(const RenderedImage& image, const std::vector<uint8_t>& ever) {
  Image8 moving{image.width, image.height, 1, std::vector<uint8_t>(ever.size())};
  for (size_t p = 0; p < ever.size(); ++p)
    if (ever[p] != 0 || image.moving_share[p] > 0)
      moving.data[p] = uint8_t(128 + std::lround(127 * image.moving_share[p]));
  return moving;
}

std::vector<double> clip_times(const SynthOptions& options) {
  std::vector<double> times;
  for (int frame = 0; frame < options.frames; ++frame) times.push_back(world_time(options, frame));
  return times;
}

}  // namespace tessera::synth
