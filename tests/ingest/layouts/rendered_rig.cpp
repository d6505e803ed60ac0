// Boxes with noise on their faces, ray-traced with 2 × 2 rays per pixel. Surfaces have the same
// colour from all directions, as feature matching requires.
#include "tests/ingest/layouts/rendered_rig.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "ingest/video/video_decoder.h"
#include "ingest/video/video_timeline.h"
#include "kernels/base/parallel.h"
#include "tests/ingest/layouts/capture_fixture.h"
#include "tests/ingest/video/test_video.h"

namespace tessera::testing {
namespace {

struct Box {
  glm::dvec3 low, high;
  int seed;
};

/// The room is seen from within, the others from outside.
const std::array<Box, 5> kBoxes{{{{-3, -9, 0}, {3, 2.5, 3.2}, 1},
                                 {{-1.8, -0.4, 0}, {-0.9, 0.5, 0.9}, 2},
                                 {{0.6, 0.3, 0}, {1.6, 1.2, 1.4}, 3},
                                 {{-0.5, 1.2, 0}, {0.4, 2.0, 2.0}, 4},
                                 {{0.3, -1.4, 0}, {0.9, -0.9, 0.5}, 5}}};

constexpr double kPanelY = 0.8;  // it stands across the room

double lattice(int x, int y, int seed) {
  uint32_t h = uint32_t(x) * 0x8da6b343u ^ uint32_t(y) * 0xd8163841u ^ uint32_t(seed) * 0xcb1ab31fu;
  h = (h ^ (h >> 13)) * 0x5bd1e995u;
  h = (h ^ (h >> 15)) * 0x2c1b3c6du;
  return double((h ^ (h >> 16)) & 0xffff) / 65535;
}

/// Smooth noise of three scales in [0, 1].
double noise(double x, double y, int seed) {
  double sum = 0, weight = 0;
  for (int octave = 0; octave < 3; ++octave) {
    const double scale = 4.0 * (1 << octave), u = x * scale, v = y * scale;
    const int i = int(std::floor(u)), j = int(std::floor(v));
    const double a = u - i, b = v - j;
    const double s = a * a * (3 - 2 * a), t = b * b * (3 - 2 * b);
    const int key = seed * 8 + octave;
    sum += (1 - t) * ((1 - s) * lattice(i, j, key) + s * lattice(i + 1, j, key)) +
           t * ((1 - s) * lattice(i, j + 1, key) + s * lattice(i + 1, j + 1, key));
    weight += 1;
  }
  return std::clamp(1.8 * (sum / weight - 0.5) + 0.5, 0.0, 1.0);
}

glm::dvec3 colour_at(double u, double v, int seed) {
  return {noise(u, v, seed), noise(u, v, seed + 100), 0.7 * noise(u, v, seed + 200)};
}

/// Nearest positive hit of the ray with the box's faces, or a large number.
double hit_box(const Box& box, const glm::dvec3& from, const glm::dvec3& along, int& axis) {
  double enter = -1e9, leave = 1e9;
  int enter_axis = 0, leave_axis = 0;
  for (int i = 0; i < 3; ++i) {
    const double a = (box.low[i] - from[i]) / along[i], b = (box.high[i] - from[i]) / along[i];
    if (std::min(a, b) > enter) {
      enter = std::min(a, b);
      enter_axis = i;
    }
    if (std::max(a, b) < leave) {
      leave = std::max(a, b);
      leave_axis = i;
    }
  }
  if (enter > leave || leave <= 0) return 1e9;
  axis = enter > 0 ? enter_axis : leave_axis;
  return enter > 0 ? enter : leave;
}

glm::dvec3 trace(const glm::dvec3& from, const glm::dvec3& along, bool has_panel, double shift) {
  double nearest = 1e9;
  glm::dvec3 colour(0);
  for (const Box& box : kBoxes) {
    int axis = 0;
    const double t = hit_box(box, from, along, axis);
    if (t >= nearest) continue;
    nearest = t;
    const glm::dvec3 point = from + t * along;
    colour = colour_at(point[(axis + 1) % 3] + 40 * axis, point[(axis + 2) % 3], box.seed);
  }
  if (!has_panel) return colour;
  const double t = (kPanelY - from.y) / along.y;  // an upright panel with texture that goes along x
  const glm::dvec3 point = from + t * along;
  if (t > 0 && t < nearest && std::abs(point.x) < 1.7 && point.z > 0.4 && point.z < 2.2)
    colour = colour_at(point.x - shift, point.z, 9);
  return colour;
}

}  // namespace

std::vector<Camera> true_cameras(const RenderedRig& rig) {
  std::vector<Camera> cameras;
  for (int i = 0; i < rig.cameras; ++i) {
    const double angle = (rig.cameras == 1 ? 0 : double(i) / (rig.cameras - 1) - 0.5) * 0.8;
    const glm::dvec3 centre(4.5 * std::sin(angle), -4.5 * std::cos(angle), i % 2 == 0 ? 1.1 : 1.9);
    const glm::dvec3 target(0, 0.5, 1.2);
    const glm::dvec3 forward = glm::normalize(target - centre);
    const glm::dvec3 right = glm::normalize(glm::cross(forward, glm::dvec3(0, 0, 1)));
    const glm::dvec3 down = glm::cross(forward, right);
    Camera camera;
    camera.width = rig.width;
    camera.height = rig.height;
    camera.fl_x = 0.9 * rig.width;
    camera.fl_y = camera.fl_x * rig.pixel_aspect;
    camera.cx = rig.width / 2.0;
    camera.cy = rig.height / 2.0;
    camera.cam_from_world = glm::transpose(glm::dmat3(right, down, forward));
    camera.translation = -(camera.cam_from_world * centre);
    cameras.push_back(camera);
  }
  return cameras;
}

double distance_to_surface(const glm::dvec3& point) {
  double nearest = std::abs(point.y - kPanelY);
  for (const Box& box : kBoxes) {
    glm::dvec3 outside(0);
    double inside = -1e9;
    for (int i = 0; i < 3; ++i) {
      const double beyond = std::max(box.low[i] - point[i], point[i] - box.high[i]);
      outside[i] = std::max(beyond, 0.0);
      inside = std::max(inside, beyond);
    }
    nearest = std::min(nearest, inside > 0 ? glm::length(outside) : -inside);
  }
  return nearest;
}

Image8 rendered_image(const RenderedRig& rig, int number, int frame) {
  const Camera camera = true_cameras(rig)[size_t(number)];
  const glm::dvec3 centre = camera.position();
  const double shift = rig.panel_step * (frame + (rig.clocks_agree ? 0 : number));
  Image8 image{rig.width, rig.height, 3, {}};
  image.data.resize(size_t(rig.width * rig.height * 3));
  parallel_for(rig.height, 8, [&](int64_t begin, int64_t end) {
    for (auto y = int(begin); y < int(end); ++y)
      for (int x = 0; x < rig.width; ++x) {
        glm::dvec3 sum(0);
        for (int s = 0; s < 4; ++s)
          sum +=
              trace(centre, ray_through(camera, x + 0.25 + 0.5 * (s % 2), y + 0.25 + s / 2 * 0.5),
                    rig.panel_step != 0, shift);
        for (int c = 0; c < 3; ++c)
          image.data[size_t((y * rig.width + x) * 3 + c)] =
              c == 2 && number == rig.blue_camera ? 255 : uint8_t(40 + 170 * sum[c] / 4);
      }
  });
  return image;
}

RigClip clip_of(const std::filesystem::path& video) {
  RigClip clip{video.stem().string(), video, {}, {}};
  decode_video(video, [&](VideoFrame frame) {
    clip.timeline.width = frame.image.width;
    clip.timeline.height = frame.image.height;
    clip.timeline.ticks.push_back(frame.ticks);
    return true;
  });
  clip.timeline.pixel_aspect = read_timeline(video).pixel_aspect;
  clip.timeline.time_base = probe_video(video).time_base;
  return clip;
}

std::vector<RigClip> write_rig(const std::filesystem::path& folder, const RenderedRig& rig) {
  std::vector<RigClip> clips;
  for (int camera = 0; camera < rig.cameras; ++camera) {
    TestVideo video;
    video.pixel_aspect = {int(std::lround(12 * rig.pixel_aspect)), 12};
    for (int frame = 0; frame < rig.frames; ++frame)
      video.frames.push_back(rendered_image(rig, camera, frame));
    const auto path = folder / fmt::format("cam{:02}.mp4", camera);
    write_video(path, video);
    clips.push_back(clip_of(path));
  }
  return clips;
}

}  // namespace tessera::testing
