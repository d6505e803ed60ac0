// What: placing solids, casting rays at them and lighting what is met.
// Not: shapes or textures themselves.
#include "tools/synth/ray_cast.h"

#include <algorithm>
#include <cmath>

namespace tessera::synth {
namespace {

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
