// Intersects and shades rays. The pixel loops are parallel over rows, which are independent, so
// that the number of threads changes no result.
#include "tools/synth/render.h"

#include <algorithm>
#include <cmath>

#include "kernels/base/parallel.h"

namespace tessera::synth {
namespace {

constexpr int64_t kRows = 4;  // rows a parallel piece

/// The pixels outside which a mover cannot be seen, by projecting the ball about it: for |offset|
/// <= r and depth in [z−r, z+r] the extremes of (offset)/(depth) lie at the corners.
PixelBox screen_bounds(const Camera& camera, const PlacedSolid& placed) {
  const glm::dvec3 c = camera.cam_from_world * placed.origin + camera.translation;
  const double r = placed.radius, near = c.z - r, far = c.z + r;
  if (far <= 0) return {};
  if (near <= 1e-3) return {0, 0, camera.width, camera.height};
  const auto low = [&](double v) { return std::min((v - r) / near, (v - r) / far); };
  const auto high = [&](double v) { return std::max((v + r) / near, (v + r) / far); };
  const auto pixel = [](double v, int size) { return int(std::clamp(v, 0.0, double(size))); };
  return {pixel(std::floor(camera.fl_x * low(c.x) + camera.cx), camera.width),
          pixel(std::floor(camera.fl_y * low(c.y) + camera.cy), camera.height),
          pixel(std::ceil(camera.fl_x * high(c.x) + camera.cx), camera.width),
          pixel(std::ceil(camera.fl_y * high(c.y) + camera.cy), camera.height)};
}

/// The placed movers of a timestep and where each may be seen.
struct Movers {
  std::vector<PlacedSolid> placed;
  std::vector<PixelBox> bounds;
};

Movers movers_at(const World& world, const Camera& camera, double time) {
  Movers movers{place(world, Part::kMoving, time), {}};
  for (const PlacedSolid& placed : movers.placed)
    movers.bounds.push_back(screen_bounds(camera, placed));
  return movers;
}

/// Samples of one pixel summed up; how many of them met a mover. The pixel joins the boxes of the
/// movers that it shows; `boxes`: one a solid.
int add_samples(const World& world, const Camera& camera, const StaticLayer& layer,
                const Movers& movers, int x, int y, glm::vec4& sum, PixelBox* boxes) {
  int changed = 0;
  bool near_mover = false;
  for (const PixelBox& bounds : movers.bounds) near_mover |= bounds.contains(x, y);
  const int count = layer.grid * layer.grid;
  const size_t first = (size_t(y) * size_t(camera.width) + size_t(x)) * size_t(count);
  for (int s = 0; s < count; ++s) {
    const float depth = layer.depth[first + size_t(s)];
    glm::vec4 value(layer.colour[first + size_t(s)], std::isinf(depth) ? 0.f : 1.f);
    if (near_mover) {
      const Ray ray = pixel_ray(camera, x + (s % layer.grid + 0.5) / layer.grid,
                                y + (s / layer.grid + 0.5) / layer.grid);
      Meeting meeting;
      meeting.hit.depth = depth;
      for (size_t i = 0; i < movers.placed.size(); ++i)
        if (movers.bounds[i].contains(x, y)) cast(ray, movers.placed[i], meeting);
      if (meeting.placed != nullptr) {
        value = glm::vec4(shade(world.light, ray, meeting, {}), 1);
        boxes[meeting.placed->solid - world.solids.data()].include({x, y, x + 1, y + 1});
        ++changed;
      }
    }
    sum += value;
  }
  return changed;
}

bool in_shadow(const glm::dvec3& point, const glm::dvec3& to_light,
               const std::vector<PlacedSolid>& casters) {
  const Ray ray{point, to_light};  // the light is at depth 1
  for (const PlacedSolid& placed : casters) {
    if (!placed.solid->shadows) continue;
    Meeting meeting;
    meeting.hit.depth = 0.999;
    cast(ray, placed, meeting);
    if (meeting.placed != nullptr) return true;
  }
  return false;
}

}  // namespace

void PixelBox::include(const PixelBox& other) {
  if (other.empty()) return;
  *this = empty() ? other
                  : PixelBox{std::min(x0, other.x0), std::min(y0, other.y0), std::max(x1, other.x1),
                             std::max(y1, other.y1)};
}

Ray pixel_ray(const Camera& camera, double x, double y) {
  const glm::dvec3 in_camera((x - camera.cx) / camera.fl_x, (y - camera.cy) / camera.fl_y, 1);
  return {camera.position(), glm::transpose(camera.cam_from_world) * in_camera};
}

StaticLayer render_static(const World& world, const Camera& camera, int grid) {
  const std::vector<PlacedSolid> solids = place(world, Part::kStatic, 0);
  const size_t count = size_t(grid) * size_t(grid);
  const size_t samples = size_t(camera.width) * size_t(camera.height) * count;
  StaticLayer layer{grid, std::vector<float>(samples), std::vector<glm::vec3>(samples)};
  parallel_for(camera.height, kRows, [&](int64_t begin, int64_t end) {
    size_t sample = size_t(begin) * size_t(camera.width) * count;
    for (int64_t y = begin; y < end; ++y)
      for (int x = 0; x < camera.width; ++x)
        for (int s = 0; s < grid * grid; ++s, ++sample) {
          const Ray ray =
              pixel_ray(camera, x + (s % grid + 0.5) / grid, double(y) + (s / grid + 0.5) / grid);
          const Meeting meeting = cast(ray, solids);
          layer.depth[sample] = float(meeting.hit.depth);
          if (meeting.placed != nullptr)
            layer.colour[sample] = shade(world.light, ray, meeting, solids);
        }
  });
  return layer;
}

RenderedImage render(const World& world, const Camera& camera, double time,
                     const StaticLayer& layer) {
  const Movers at_time = movers_at(world, camera, time);
  const size_t pixels = size_t(camera.width) * size_t(camera.height);
  RenderedImage image{camera.width, camera.height, std::vector<float>(4 * pixels),
                      std::vector<uint8_t>(pixels), std::vector<float>(pixels)};
  const float of_sample = 1.f / float(layer.grid * layer.grid);
  const size_t count = world.solids.size();
  std::vector<PixelBox> boxes(size_t(camera.height) * count);  // of each image row and solid
  parallel_for(camera.height, kRows, [&](int64_t begin, int64_t end) {
    for (int64_t y = begin; y < end; ++y) {
      const double share = (double(y) + 0.5) / camera.height - 0.5;
      const Movers movers =
          camera.readout == 0 ? at_time : movers_at(world, camera, time + camera.readout * share);
      for (int x = 0; x < camera.width; ++x) {
        const size_t pixel = size_t(y) * size_t(camera.width) + size_t(x);
        glm::vec4 sum(0);
        const int changed = add_samples(world, camera, layer, movers, x, int(y), sum,
                                        boxes.data() + size_t(y) * count);
        if (changed > 0) image.mask[pixel] = 255;
        image.moving_share[pixel] = float(changed) * of_sample;
        if (sum.a > 0) {
          const glm::vec3 straight = glm::vec3(sum) / sum.a;
          for (int k = 0; k < 3; ++k) image.rgba[4 * pixel + size_t(k)] = straight[k];
        }
        image.rgba[4 * pixel + 3] = sum.a * of_sample;
      }
    }
  });
  for (size_t i = 0; i < boxes.size(); ++i)
    if (!boxes[i].empty()) image.boxes[world.solids[i % count].name].include(boxes[i]);
  return image;
}

RenderedImage render(const World& world, const Camera& camera, double time, int grid) {
  return render(world, camera, time, render_static(world, camera, grid));
}

std::vector<PlacedSolid> place(const World& world, Part part, double time) {
  std::vector<PlacedSolid> placed;
  for (const Solid& solid : world.solids) {
    if (solid.moves != (part == Part::kMoving) || !solid.lifetime.contains(time)) continue;
    const double timestep = solid.moves ? time : 0;
    const Pose pose = carried(solid.joints, pose_at(solid.motion, timestep), timestep);
    const double growth = std::max({glm::length(pose.linear[0]), glm::length(pose.linear[1]),
                                    glm::length(pose.linear[2])});  // columns are orthogonal
    placed.push_back({&solid, timestep, glm::inverse(pose.linear), pose.origin,
                      growth * bounding_radius(solid.shape)});
  }
  return placed;
}

void cast(const Ray& ray, const PlacedSolid& placed, Meeting& meeting) {
  const glm::dvec3 origin = placed.object_from_world * (ray.origin - placed.origin);
  const glm::dvec3 direction = placed.object_from_world * ray.direction;
  if (intersect(placed.solid->shape, origin, direction, placed.time, meeting.hit))
    meeting.placed = &placed;
}

Meeting cast(const Ray& ray, const std::vector<PlacedSolid>& solids) {
  Meeting meeting;
  for (const PlacedSolid& placed : solids) cast(ray, placed, meeting);
  return meeting;
}

glm::vec3 shade(const Light& light, const Ray& ray, const Meeting& meeting,
                const std::vector<PlacedSolid>& casters) {
  const PlacedSolid& placed = *meeting.placed;
  const glm::vec3 albedo = sample(placed.solid->texture, meeting.hit.point, meeting.hit.axis);
  // Normals go by the inverse transpose of world from object.
  glm::dvec3 normal = glm::normalize(glm::transpose(placed.object_from_world) * meeting.hit.normal);
  if (glm::dot(normal, ray.direction) > 0) normal = -normal;
  const glm::dvec3 point = ray.origin + meeting.hit.depth * ray.direction + 1e-5 * normal;
  const glm::dvec3 to_light = light.position - point, to_light_unit = glm::normalize(to_light);
  double lit = std::max(0.0, glm::dot(normal, to_light_unit));
  if (lit > 0 && placed.solid->shadows && in_shadow(point, to_light, casters)) lit = 0;
  double glint = 0;
  if (light.specular > 0 && lit > 0) {
    const glm::dvec3 half = glm::normalize(to_light_unit - glm::normalize(ray.direction));
    glint = light.specular * std::pow(std::max(0.0, glm::dot(normal, half)), 40.0);
  }
  const double ambient = light.ambient * (0.85 + 0.15 * normal.z);
  const glm::vec3 colour = albedo * float(ambient + light.diffuse * lit) + float(glint);
  return glm::clamp(colour, 0.03f, 0.97f);
}

}  // namespace tessera::synth
