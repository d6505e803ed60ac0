// Sizes and copies of the arrays of motion nodes.
#include "recon4d/model/motion_nodes.h"

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

void MotionNodes::resize(int64_t nodes, int control_points) {
  count = nodes;
  knots = control_points;
  position.resize(3 * nodes);
  const int64_t scalars[] = {nodes, 3 * nodes * control_points, 4 * nodes * control_points};
  for (size_t g = 0; g < groups().size(); ++g) {
    ParameterGroup& group = *groups()[g];
    group.value.resize(scalars[g]);
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
  copy.count = count;
  copy.knots = knots;
  copy.started = started;
  copy.refitted = refitted;
  copy.position.copy_from(position);
  for (size_t g = 0; g < groups().size(); ++g) {
    ParameterGroup& to = *copy.groups()[g];
    const ParameterGroup& from = *groups()[g];
    to.value.copy_from(from.value);
    if (!moments) continue;
    to.moment1.copy_from(from.moment1);
    to.moment2.copy_from(from.moment2);
  }
  return copy;
}

}  // namespace tessera
