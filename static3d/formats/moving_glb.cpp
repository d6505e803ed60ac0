// The primitive of what is at rest, a node for each group, and the channels that animate them.
#include "static3d/formats/moving_glb.h"

#include <algorithm>
#include <cmath>

#include "kernels/batch.h"
#include "recon4d/evaluation/render.h"
#include "recon4d/model/element_edits.h"
#include "static3d/formats/glb_file.h"
#include "static3d/transform/lifetime_groups.h"
#include "static3d/transform/rigid_groups.h"
#include "static3d/transform/scene_box.h"
#include "static3d/transform/world_change.h"

namespace tessera {
namespace {

using nlohmann::json;

constexpr AxisSigns kAxes = kLeftUpFront;

/// A place of the world as the file has it.
std::vector<float> file_place(const Vec3<double>& x) {
  return {float(x[0]) * kAxes.x, float(x[1]) * kAxes.y, float(x[2]) * kAxes.z};
}

/// A rotation of the world as the file has it: x, y, z, w.
std::vector<float> file_rotation(const Vec4<double>& q) {
  return {float(q[1]) * kAxes.y * kAxes.z, float(q[2]) * kAxes.x * kAxes.z,
          float(q[3]) * kAxes.x * kAxes.y, float(q[0])};
}

void extend(std::vector<float>& to, const std::vector<float>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

/// Nodes under the root, and the channels of their animation.
class AnimatedNodes {
 public:
  explicit AnimatedNodes(GlbFile& file) : file_(file) { file_.add_node(json::object()); }

  size_t add(size_t mesh) {
    children_.push_back(file_.add_node({{"mesh", mesh}}));
    return children_.back();
  }
  /// `times`: accessor of keyframe times. The node is at the first key where nothing is played.
  void animate(size_t node, const char* path, size_t times, const std::vector<float>& values,
               int width, const char* interpolation) {
    channels_.push_back(
        {{"sampler", samplers_.size()}, {"target", {{"node", node}, {"path", path}}}});
    samplers_.push_back({{"input", times},
                         {"output", file_.add_floats(values, width, false)},
                         {"interpolation", interpolation}});
    file_.node(node)[path] = std::vector<float>(values.begin(), values.begin() + width);
  }
  void finish() {
    if (!children_.empty()) file_.node(0)["children"] = children_;
    if (!channels_.empty())
      file_.set_animation({{"name", "clip"}, {"channels", channels_}, {"samplers", samplers_}});
  }

 private:
  GlbFile& file_;
  std::vector<size_t> children_;
  json channels_ = json::array(), samplers_ = json::array();
};

/// The dynamic Gaussians as static ones in the frames of their groups.
GaussianSet local_dynamic(const GaussianModel& model, const std::vector<MovingGaussian>& moving,
                          const LifetimeGroups& groups) {
  const GaussianSpans<const float> source = model.dynamic_set.values();
  GaussianSet set(SetForm::kStatic, model.dynamic_set.coefficients());
  set.resize(int64_t(moving.size()));
  const GaussianSpans<float> to = set.values();
  const ColourRules<float> colours =
      make_colour_rules<float>(render_options(model), source.coefficients, source.time_levels);
  for (int64_t i = 0; i < set.count(); ++i) {
    const MovingGaussian& g = moving[size_t(i)];
    for (int k = 0; k < 3; ++k) {
      to.at(kMean, i)[k] = g.mean[k];
      to.at(kLogScale, i)[k] = g.log_scale[k];
    }
    for (int k = 0; k < 4; ++k) to.at(kRotation, i)[k] = g.rotation[k];
    *to.at(kOpacityLogit, i) = *source.at(kOpacityLogit, g.source);
    std::copy_n(source.at(kSh, g.source), source.width(kSh), to.at(kSh, i));
    const float brightest = std::clamp(g.spacetime.mean_time, 0.0f, 1.0f);
    add_levels(colours, brightest - g.spacetime.mean_time, source.at(kShTime, g.source),
               to.at(kSh, i));
  }
  // exact at its own temporal mean
  for (const LifetimeGroup& group : groups.groups)
    for (const int64_t i : group.members) {
      const double delta = double(moving[size_t(i)].spacetime.mean_time) - group.mean_time;
      for (int k = 0; k < 3; ++k) to.at(kMean, i)[k] -= float(group.velocity[k] * delta);
    }
  return set;
}

/// Adds the elements of `from` at `elements` behind those of `to`.
void append_still(const GaussianSet& from, const std::vector<int64_t>& elements, GaussianSet& to) {
  const GaussianSet old = to.clone_values();
  const int64_t before = old.count();
  to.resize(before + int64_t(elements.size()));
  const GaussianSpans<float> values = to.values();
  std::fill(to.group(kSh).value.begin(), to.group(kSh).value.end(), 0.0f);
  for (const Group g : {kMean, kLogScale, kRotation, kOpacityLogit, kSh}) {
    std::copy(old.group(g).value.begin(), old.group(g).value.end(), to.group(g).value.begin());
    for (size_t i = 0; i < elements.size(); ++i)
      std::copy_n(from.values().at(g, elements[i]), from.width(g),
                  values.at(g, before + int64_t(i)));
  }
}

class Writer {
 public:
  Writer(const GaussianModel& model, double fps) : model_(model), fps_(fps), nodes_(file_) {}

  MovingGlbReport save(const std::filesystem::path& path) {
    const auto stored = [](const GaussianSet& s) { return s.count() > 0 ? s.coefficients() : 1; };
    GaussianSet still(SetForm::kStatic,
                      std::max(stored(model_.static_set), stored(model_.dynamic_set)));
    still.resize(0);
    add_static(still);
    add_dynamic(still);
    if (still.count() > 0) file_.node(0)["mesh"] = mesh(still);
    nodes_.finish();
    report_.bytes = file_.save(path);
    const double extent = scene_box(model_).half_extent;
    for (double* const error : {&report_.rms_motion_error, &report_.rms_velocity_error})
      if (extent > 0) *error /= extent;
    return report_;
  }

 private:
  size_t mesh(const GaussianSet& set) {
    report_.gaussians += set.count();
    return file_.add_mesh(set,
                          std::min(model_.drawing.sh_degree, sh_degree_of(set.coefficients())));
  }

  size_t group_node(const GaussianSet& local, const std::vector<int64_t>& members) {
    ++report_.groups;
    return nodes_.add(mesh(select_elements(local, members)));
  }

  void add_static(GaussianSet& still) {
    const std::vector<int64_t> valid = valid_elements(model_.static_set);
    report_.non_finite += model_.static_set.count() - int64_t(valid.size());
    if (model_.nodes.empty()) return append_still(model_.static_set, valid, still);
    const int64_t keys = std::max<int64_t>(2, std::llround(fps_ * model_.time_axis.duration) + 1);
    std::vector<double> times;
    std::vector<float> seconds;
    for (int64_t i = 0; i < keys; ++i) {
      times.push_back(double(i) / double(keys - 1));
      seconds.push_back(float(times.back() * model_.time_axis.duration));
    }
    const RigidGroups groups =
        rigid_groups(select_elements(model_.static_set, valid), model_.nodes, times);
    report_.rms_motion_error = groups.rms_error;
    append_still(groups.local, groups.fixed, still);
    if (groups.groups.empty()) return;
    report_.keys = keys;
    const size_t input = file_.add_floats(seconds, 1, true);
    for (const RigidGroup& group : groups.groups) {
      std::vector<float> places, rotations;
      for (const RigidPose& pose : group.poses) {
        extend(places, file_place(pose.translation));
        extend(rotations, file_rotation(pose.rotation));
      }
      const size_t node = group_node(groups.local, group.members);
      nodes_.animate(node, "translation", input, places, 3, "LINEAR");
      nodes_.animate(node, "rotation", input, rotations, 4, "LINEAR");
    }
  }

  void add_dynamic(GaussianSet& still) {
    const Slicer slicer(model_);
    report_.non_finite += slicer.invalid();
    std::vector<MovingGaussian> moving;
    for (const MovingGaussian& g : slicer.moving())
      if (is_valid_element(model_.dynamic_set.values(), g.source)) moving.push_back(g);
    report_.non_finite += int64_t(slicer.moving().size() - moving.size());
    const LifetimeGroups groups =
        lifetime_groups(moving, model_.drawing.time_filter, double(scene_box(model_).half_extent));
    report_.never_drawn = int64_t(groups.never_drawn.size());
    report_.rms_velocity_error = groups.rms_error;
    const GaussianSet local = local_dynamic(model_, moving, groups);
    append_still(local, groups.fixed, still);
    const auto seconds = float(model_.time_axis.duration);
    size_t ends = 0;  // accessor of the clip's first and last time
    if (!groups.groups.empty()) ends = file_.add_floats({0, seconds}, 1, true);
    for (const LifetimeGroup& group : groups.groups) {
      const size_t node = group_node(local, group.members);
      std::vector<float> places = file_place(group.velocity * -group.mean_time);
      extend(places, file_place(group.velocity * (1 - group.mean_time)));
      nodes_.animate(node, "translation", ends, places, 3, "LINEAR");
      show_and_hide(node, float(group.begin) * seconds, float(group.end) * seconds, seconds);
    }
  }

  /// Scales 0 and 1, from keyframe to keyframe.
  void show_and_hide(size_t node, float begin, float end, float clip_end) {
    std::vector<float> times{0}, scales(3, begin > 0 ? 0.0f : 1.0f);
    const auto key = [&](float time, float scale) {
      times.push_back(std::max(time, std::nextafter(times.back(), INFINITY)));
      scales.insert(scales.end(), 3, scale);
    };
    if (begin > 0) key(begin, 1);
    if (end < clip_end) key(end, 0);
    if (times.size() < 2) return;
    nodes_.animate(node, "scale", file_.add_floats(times, 1, true), scales, 3, "STEP");
  }

  const GaussianModel& model_;
  double fps_;
  GlbFile file_;
  AnimatedNodes nodes_;
  MovingGlbReport report_;
};

}  // namespace

MovingGlbReport save_moving_glb(const std::filesystem::path& path, const GaussianModel& model,
                                double fps) {
  return Writer(model, fps).save(path);
}

}  // namespace tessera
