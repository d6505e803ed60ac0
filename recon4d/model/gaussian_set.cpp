// Sizes and copies of the parameter groups of sets, of motion nodes and of statistics.
#include "recon4d/model/gaussian_set.h"

#include <algorithm>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

template <class T, class Self>
NodeSpans<T> spans_of(Self& nodes) {
  return {nodes.count,
          nodes.knots,
          nodes.position.span(),
          nodes.log_radius.value.span(),
          nodes.translation.value.span(),
          nodes.rotation.value.span()};
}

}  // namespace

ParameterGroup ParameterGroup::clone_to(Memory& memory, bool moments) const {
  ParameterGroup copy(memory);
  copy.value.copy_from(value);
  if (!moments) return copy;
  copy.moment1.copy_from(moment1);
  copy.moment2.copy_from(moment2);
  return copy;
}

void MotionNodes::resize(int64_t nodes, int control_points) {
  count = nodes;
  knots = control_points;
  position.resize(3 * nodes);
  for (size_t g = 0; g < groups().size(); ++g) {
    ParameterGroup& group = *groups()[g];
    group.value.resize(scalars()[g]);
    group.moment1.resize(0);
    group.moment2.resize(0);
  }
}

void MotionNodes::ensure_moments() {
  check(&position.memory() == &host_memory(), "MotionNodes: moments are made on the host");
  for (ParameterGroup* const group : groups())
    for (Buffer<float>* const moments : {&group->moment1, &group->moment2}) {
      if (moments->size() == group->value.size()) continue;
      moments->resize(group->value.size());
      std::fill(moments->begin(), moments->end(), 0.0f);
    }
}

NodeSpans<float> MotionNodes::spans() {
  return spans_of<float>(*this);
}

NodeSpans<const float> MotionNodes::spans() const {
  return spans_of<const float>(*this);
}

MotionNodes MotionNodes::clone_to(Memory& memory, bool moments) const {
  MotionNodes copy(memory);
  static_cast<NodeCounts&>(copy) = *this;
  copy.position.copy_from(position);
  for (size_t g = 0; g < groups().size(); ++g)
    *copy.groups()[g] = groups()[g]->clone_to(memory, moments);
  return copy;
}

GaussianSet::GaussianSet(SetForm form, int coefficients, Memory& memory, int time_levels)
    : form_(form), coefficients_(coefficients), time_levels_(time_levels), memory_(&memory) {
  check(time_levels == 0 || is_dynamic(form), "GaussianSet: a static set with levels of time");
  for (ParameterGroup& group : groups_) group = ParameterGroup(memory);
}

int GaussianSet::width(Group group) const {
  check(!blocks_.mixed() || (group != kSh && group != kShTime),
        "GaussianSet: elements of a set of several SH degrees have no common width");
  return group_width(group, coefficients_, form_, time_levels_);
}

int64_t GaussianSet::scalars(Group group, int64_t count, const ShBlocks& blocks) const {
  if (!blocks.mixed() || (group != kSh && group != kShTime))
    return count * group_width(group, coefficients_, form_, time_levels_);
  return blocks.coefficients() * group_width(group, 1, form_, time_levels_);
}

void GaussianSet::declare(int64_t count, const ShBlocks& blocks) {
  check(!blocks.mixed() || blocks.count() == count, "GaussianSet: elements of the blocks");
  const int degree = sh_degree_of(coefficients_);
  for (int above = degree + 1; above <= kMaxShDegree; ++above)
    check(blocks.elements[above] == 0, "GaussianSet: a block of more coefficients than the set");
  const bool alike = coefficients_ == sh_coefficients(degree) && blocks.elements[degree] == count;
  count_ = count, blocks_ = alike ? ShBlocks{} : blocks;
}

void GaussianSet::resize(int64_t count, const ShBlocks& blocks) {
  declare(count, blocks);
  for (int g = 0; g < groups(); ++g) {
    ParameterGroup& group = groups_[size_t(g)];
    group.value.resize(scalars(Group(g)));
    group.moment1 = Buffer<float>(*memory_);
    group.moment2 = Buffer<float>(*memory_);
  }
}

void GaussianSet::set_count(int64_t count, const ShBlocks& blocks) {
  for (int g = 0; g < groups(); ++g)
    check(groups_[size_t(g)].value.size() == scalars(Group(g), count, blocks),
          "GaussianSet: elements of a group");
  declare(count, blocks);
}

void GaussianSet::ensure_moments() {
  if (has_moments()) return;
  check(memory_ == &host_memory(), "GaussianSet: moments are made on the host");
  for (int g = 0; g < groups(); ++g) {
    ParameterGroup& group = groups_[size_t(g)];
    const int buffers = moment_buffers(Group(g));
    group.moment1.resize(buffers > 0 ? group.value.size() : 0);
    group.moment2.resize(buffers > 1 ? group.value.size() : 0);
    std::fill(group.moment1.begin(), group.moment1.end(), 0.0f);
    std::fill(group.moment2.begin(), group.moment2.end(), 0.0f);
  }
}

GaussianSet GaussianSet::clone_to(Memory& memory, bool moments) const {
  GaussianSet copy = like(memory);
  copy.count_ = count_;
  copy.blocks_ = blocks_;
  for (int g = 0; g < groups(); ++g)
    copy.groups_[size_t(g)] = groups_[size_t(g)].clone_to(memory, moments);
  return copy;
}

int64_t GaussianSet::value_bytes() const {
  int64_t sum = 0;
  for (int g = 0; g < groups(); ++g) sum += scalars(Group(g));
  return sum * int64_t(sizeof(float));
}

EnvironmentLight EnvironmentLight::clone_to(Memory& memory, bool moments) const {
  EnvironmentLight copy;
  copy.height = height;
  copy.map_from_world = map_from_world;
  copy.map = map.clone_to(memory, moments);
  return copy;
}

GaussianModel GaussianModel::clone_to(Memory& memory, bool moments) const {
  GaussianModel copy;
  static_cast<ModelSettings&>(copy) = *this;
  copy.static_set = static_set.clone_to(memory, moments);
  copy.dynamic_set = dynamic_set.clone_to(memory, moments);
  copy.nodes = nodes.clone_to(memory, moments);
  copy.environment = environment.clone_to(memory, moments);
  return copy;
}

void SetStatistics::reset(int64_t gaussians) {
  check(&count.memory() == &host_memory(), "SetStatistics: a device is reset by its backend");
  for (Buffer<float>* values : {&gradient_sum, &count}) {
    values->resize(gaussians);
    std::fill(values->begin(), values->end(), 0.0f);
  }
  filter_size.resize(0);
}

void SetStatistics::reset(Backend& backend, int64_t gaussians) {
  for (Buffer<float>* values : {&gradient_sum, &count}) {
    values->resize(gaussians);
    backend.fill_zero(values->span());
  }
  filter_size.resize(0);
}

SetStatistics SetStatistics::clone_to(Memory& memory) const {
  SetStatistics copy(memory);
  copy.gradient_sum.copy_from(gradient_sum);
  copy.count.copy_from(count);
  copy.filter_size.copy_from(filter_size);
  return copy;
}

void apply_light(const LightGain& light, GaussianSet& set) {
  check(set.time_levels() == 0, "apply_light: a set with levels of time");
  const GaussianSpans<float> values = set.values();
  const int width = set.width(kSh);
  for (int64_t n = 0; n < set.count(); ++n) {
    float* const sh = values.at(kSh, n);
    for (int i = 0; i < width; ++i) {
      const double factor = light[size_t(i % 3)], offset = i < 3 ? 0.5 / kSh0 : 0;
      sh[i] = float((sh[i] + offset) * factor - offset);
    }
  }
}

}  // namespace tessera
