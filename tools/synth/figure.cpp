// The figure: a body of rigid, textured parts on marching joints, with a skirt and a scarf. It
// faces -y, is 2.2 high about the origin, and no part of it is static. Rays that miss it are
// transparent.
#include <string>
#include <utility>

#include "tools/synth/world.h"

namespace tessera::synth {
namespace {

using glm::dvec3;
using Chain = std::vector<Joint>;

constexpr double kStrides = 2;  // of each leg, over the clip
// Positive angles about these turn what hangs down forward, backward and to the figure's left.
constexpr dvec3 kForward(-1, 0, 0), kBackward(1, 0, 0), kOutLeft(0, -1, 0), kUp(0, 0, 1);

Turn swing(const dvec3& axis, double mean, double amplitude, double cycles, double phase = 0) {
  return {axis, {mean, amplitude, cycles, phase}};
}

Chain with_joint(Chain chain, const dvec3& pivot, std::vector<Turn> turns) {
  chain.push_back({pivot, std::move(turns), dvec3(0), {}});
  return chain;
}

/// The end of a part and its roundness there.
struct End {
  dvec3 centre;
  double radius;
};

/// The end of the next part at a joint: a little smaller, so that no two surfaces coincide.
End within(const End& end) {
  return {end.centre, 0.97 * end.radius};
}

/// Adds parts that all belong to one chain of joints.
class PartBuilder {
 public:
  PartBuilder(WorldBuilder& builder, const Chain& chain) : builder_(builder), chain_(chain) {}

  Solid& solid(const std::string& name, ShapeKind kind, const dvec3& half, const dvec3& centre,
               const Texture& texture) {
    Solid& added = builder_.add_mover(name.c_str(), kind, half, centre, texture);
    added.joints = chain_;
    return added;
  }

  /// A round cone from `top` (its +z) to `bottom`, `depth` times as deep as it is wide.
  void limb(const std::string& name, const End& top, const End& bottom, const Texture& texture,
            double depth = 1) {
    const dvec3 axis = top.centre - bottom.centre, up = glm::normalize(axis);
    const dvec3 back = glm::normalize(glm::cross(up, dvec3(1, 0, 0)));
    Solid& added =
        solid(name, ShapeKind::kRoundCone, {bottom.radius, top.radius, 0.5 * glm::length(axis)},
              0.5 * (top.centre + bottom.centre), texture);
    added.motion.rest_rotation = glm::dmat3(glm::cross(back, up), depth * back, up);
  }

  void ball(const std::string& name, const End& middle, const Texture& texture,
            const dvec3& sizes = dvec3(1)) {
    Solid& added = solid(name, ShapeKind::kSphere, dvec3(middle.radius), middle.centre, texture);
    added.motion.rest_rotation = glm::dmat3(sizes.x, 0, 0, 0, sizes.y, 0, 0, 0, sizes.z);
  }

 private:
  WorldBuilder& builder_;
  const Chain& chain_;
};

Texture skin(WorldBuilder& b) {
  return b.texture(TextureKind::kMarble, 0.11, {.80f, .56f, .42f}, {.90f, .70f, .56f},
                   {.96f, .84f, .74f});
}

/// side: +1 the figure's left, -1 its right, which steps half a cycle later.
void add_leg(WorldBuilder& b, const Chain& pelvis, int side) {
  const std::string name = side > 0 ? "left " : "right ";
  const double x = 0.095 * side, phase = side > 0 ? 0 : 0.5;
  const End hip{{x, 0, -0.03}, 0.1}, knee{{x, 0, -0.52}, 0.076}, ankle{{x, 0, -0.98}, 0.056};
  const Chain thigh = with_joint(pelvis, hip.centre, {swing(kForward, 18, 24, kStrides, phase)});
  const Chain shin =
      with_joint(thigh, knee.centre, {swing(kBackward, 44, 43, kStrides, phase + 0.1)});
  const Chain foot = with_joint(shin, ankle.centre, {swing(kBackward, 0, 12, kStrides, phase)});
  const Texture leggings = b.texture(TextureKind::kBrick, 0.13, {.22f, .30f, .52f},
                                     {.34f, .46f, .70f}, {.88f, .84f, .66f});
  PartBuilder(b, thigh).limb(name + "thigh", hip, knee, leggings);
  const Texture socks =
      side > 0
          ? b.texture(TextureKind::kChecker, 0.085, {.90f, .84f, .74f}, {.70f, .22f, .20f}, {})
          : b.texture(TextureKind::kChecker, 0.085, {.90f, .86f, .70f}, {.20f, .46f, .36f}, {});
  PartBuilder(b, shin).limb(name + "shin", within(knee), ankle, socks);
  const Texture boot = b.texture(TextureKind::kPatches, 0.09, {.36f, .22f, .16f},
                                 {.50f, .32f, .20f}, {.92f, .78f, .40f});
  PartBuilder(b, foot).limb(name + "foot", {{x, 0.03, -1.0}, 0.068}, {{x, -0.15, -1.025}, 0.05},
                            boot);
}

void add_arm(WorldBuilder& b, const Chain& chest, int side) {
  const std::string name = side > 0 ? "left " : "right ";
  const double x = 0.24 * side, phase = side > 0 ? 0.5 : 0;  // an arm goes against its leg
  const End shoulder{{x, 0, 0.47}, 0.085}, elbow{{x, 0, 0.14}, 0.06}, wrist{{x, 0, -0.14}, 0.045};
  const Chain upper = with_joint(chest, shoulder.centre,
                                 {swing(double(side) * kOutLeft, 16, 4, 2 * kStrides),
                                  swing(kForward, 4, 38, kStrides, phase)});
  const Chain lower = with_joint(upper, elbow.centre, {swing(kForward, 52, 38, kStrides, phase)});
  const Chain hand = with_joint(lower, wrist.centre, {swing(kUp, 0, 25, kStrides, phase + 0.25)});
  const Texture sleeve = side > 0 ? b.texture(TextureKind::kPlanks, 0.07, {.88f, .62f, .24f},
                                              {.96f, .80f, .44f}, {.46f, .20f, .16f})
                                  : b.texture(TextureKind::kPlanks, 0.07, {.30f, .58f, .60f},
                                              {.52f, .78f, .74f}, {.14f, .24f, .36f});
  PartBuilder(b, upper).limb(name + "upper arm", shoulder, elbow, sleeve);
  PartBuilder(b, lower).limb(name + "forearm", within(elbow), wrist, skin(b));
  const Texture glove =
      b.texture(TextureKind::kChecker, 0.05, {.74f, .26f, .24f}, {.94f, .86f, .72f}, {});
  PartBuilder(b, hand).limb(name + "hand", {{x, 0, -0.15}, 0.048}, {{x, -0.01, -0.23}, 0.04}, glove,
                            0.7);
}

void add_head(WorldBuilder& b, const Chain& chest) {
  const Chain head = with_joint(chest, {0, 0, 0.68},
                                {swing(kBackward, 0, 5, 2 * kStrides), swing(kUp, 0, 24, 1, 0.25)});
  PartBuilder parts(b, head);
  parts.limb("neck", {{0, -0.01, 0.78}, 0.065}, {{0, 0, 0.62}, 0.075}, skin(b));
  parts.ball("head", {{0, -0.01, 0.89}, 0.165}, skin(b), {0.92, 1, 1.16});
  const Texture hair = b.texture(TextureKind::kPlanks, 0.06, {.34f, .18f, .10f}, {.58f, .34f, .16f},
                                 {.16f, .08f, .06f});
  parts.ball("hair", {{0, 0.035, 0.93}, 0.167}, hair, {0.99, 0.95, 1.06});
  parts.ball("bun", {{0, 0.2, 0.97}, 0.075}, hair);
  Texture plain = hair;
  plain.kind = TextureKind::kPlain;
  for (const int side : {-1, 1}) {
    plain.a = {.95f, .95f, .92f};
    parts.ball("eye", {{0.062 * side, -0.142, 0.91}, 0.032}, plain);
    plain.a = {.14f, .22f, .30f};
    parts.ball("pupil", {{0.064 * side, -0.166, 0.908}, 0.017}, plain);
  }
  plain.a = {.72f, .24f, .22f};
  parts.ball("mouth", {{0, -0.138, 0.805}, 0.03}, plain, {1.4, 1, 0.5});
  parts.limb("nose", {{0, -0.17, 0.885}, 0.016}, {{0, -0.188, 0.85}, 0.022}, skin(b));
}

/// Pinned at its upper edge behind the neck, it flies behind the back.
void add_scarf(WorldBuilder& b, const Chain& chest) {
  const Texture weave = b.texture(TextureKind::kPatches, 0.1, {.86f, .34f, .22f},
                                  {.94f, .56f, .30f}, {.96f, .90f, .70f});
  PartBuilder(b, chest).limb("scarf collar", {{0, -0.005, 0.7}, 0.1}, {{0, 0.0, 0.66}, 0.11},
                             weave);
  constexpr double kHalfLength = 0.27;
  const dvec3 knot(0, 0.09, 0.68);
  const Chain flight = with_joint(
      chest, knot, {swing(kBackward, 30, 12, 2 * kStrides, 0.1), swing(kUp, 0, 14, 1, 0.6)});
  Solid& scarf = PartBuilder(b, flight).solid("scarf", ShapeKind::kCloth, {0.11, kHalfLength, 0.05},
                                              knot - dvec3(0, 0, kHalfLength), weave);
  scarf.motion.rest_rotation = turn_z(180) * turn_x(90);  // local y is up, local z backward
  scarf.shape.wave_cycles = 2 * kStrides;
}

void add_trunk(WorldBuilder& b, const Chain& pelvis, const Chain& chest) {
  const Texture shorts =
      b.texture(TextureKind::kChecker, 0.1, {.20f, .24f, .40f}, {.30f, .36f, .54f}, {});
  PartBuilder hips(b, pelvis);
  hips.limb("pelvis", {{0, 0, 0.12}, 0.165}, {{0, 0, -0.02}, 0.175}, shorts, 0.75);
  const Texture leather =
      b.texture(TextureKind::kChecker, 0.06, {.34f, .20f, .12f}, {.90f, .76f, .36f}, {});
  hips.solid("belt", ShapeKind::kCylinder, {0.19, 0.19, 0.03}, {0, 0, 0.13}, leather)
      .motion.rest_rotation = glm::dmat3(1, 0, 0, 0, 0.82, 0, 0, 0, 1);
  const Texture gores = b.texture(TextureKind::kPatches, 0.12, {.46f, .20f, .48f},
                                  {.66f, .36f, .66f}, {.96f, .86f, .46f});
  Solid& skirt =
      hips.solid("skirt", ShapeKind::kSkirt, {0.185, 0.375, 0.195}, {0, 0, -0.07}, gores);
  skirt.motion.rest_rotation = glm::dmat3(1, 0, 0, 0, 0.85, 0, 0, 0, 1);
  skirt.shape.wave_cycles = kStrides;
  const Texture shirt = b.texture(TextureKind::kPatches, 0.1, {.24f, .52f, .44f},
                                  {.44f, .70f, .54f}, {.95f, .90f, .72f});
  PartBuilder(b, chest).limb("chest", {{0, 0, 0.42}, 0.26}, {{0, 0, 0.14}, 0.165}, shirt, 0.6);
}

}  // namespace

World build_figure(uint32_t seed) {
  WorldBuilder builder(seed);
  const Joint root{{0, 0, 0}, {swing(kUp, 0, 20, 1)}, kUp, {0, 0.02, 2 * kStrides}};
  const Chain pelvis = with_joint({root}, {0, 0, 0.05}, {swing(kUp, 0, -7, kStrides)});
  const Chain chest = with_joint(
      pelvis, {0, 0, 0.14}, {swing(kBackward, 5, 4, 2 * kStrides), swing(kUp, 0, 19, kStrides)});
  add_trunk(builder, pelvis, chest);
  for (const int side : {1, -1}) {
    add_leg(builder, pelvis, side);
    add_arm(builder, chest, side);
  }
  add_head(builder, chest);
  add_scarf(builder, chest);
  builder.world.light = {{2.5, -3, 5}, 0.5, 0.55};
  builder.world.target = {0, 0, 0};
  return builder.world;
}

}  // namespace tessera::synth
