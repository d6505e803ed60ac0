// Groups by dominant nodes, splits of those groups by pairs where that lowers the error, and the
// poses of groups, which come from the stage that carries Gaussians for the renderer.
#include "static3d/transform/rigid_groups.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numeric>

#include "kernels/base/errors.h"
#include "kernels/math/carry.h"
#include "recon4d/evaluation/render.h"

namespace tessera {
namespace {

constexpr float kDominant = 0.6f;    // a smaller largest weight makes a Gaussian part of a pair
constexpr double kLeastGain = 1e-4;  // of the extent of the set: RMS error that a split removes

using Members = std::vector<std::vector<int64_t>>;

/// The set as its nodes carry it at a time.
class CarriedSet {
 public:
  CarriedSet(const GaussianSet& set, const MotionNodes& nodes) : set_(set), nodes_(nodes) {}
  void at(double time) {
    const ViewBatch<float> batch = make_view_batch<float>({{Camera{}, time}});
    host_->carry({&batch, set_.values(), nodes_.spans()}, carried_);
  }
  Vec3<double> mean(int64_t n) const { return Vec3<double>(carried_.gaussians[n].mean); }
  Vec4<float> rotation(int64_t n) const { return carried_.gaussians[n].rotation; }
  const float* weights(int64_t n) const { return carried_.weights.data() + kBindings * n; }
  const NodePose<float>* poses() const { return carried_.poses.data(); }

 private:
  const GaussianSet& set_;
  const MotionNodes& nodes_;
  const std::unique_ptr<Backend> host_ = make_cpu_backend();
  Carried<float> carried_;
};

/// The two heaviest nodes of a Gaussian; −1: none.
struct Heaviest {
  int first = -1, second = -1;
  float weight = 0;  // of the first
};

Heaviest heaviest(const float* node, const float* weight) {
  Heaviest h;
  float next = 0;
  for (int k = 0; k < kBindings; ++k) {
    if (node[k] < 0) continue;
    if (h.first < 0 || weight[k] > h.weight) {
      h.second = h.first;
      next = h.weight;
      h.first = int(node[k]);
      h.weight = weight[k];
    } else if (h.second < 0 || weight[k] > next) {
      h.second = int(node[k]);
      next = weight[k];
    }
  }
  return h;
}

/// For each node that keeps a group, itself; for others the nearest that does; by node.
std::vector<int> merged_nodes(const std::vector<int64_t>& size, const MotionNodes& nodes,
                              int64_t most) {
  std::vector<int> order(size.size()), result(size.size());
  std::iota(order.begin(), order.end(), 0);
  std::iota(result.begin(), result.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return size[size_t(a)] > size[size_t(b)]; });
  const auto place = [&](int m) {
    const float* const p = nodes.position.data() + 3 * m;
    return Vec3<float>(p[0], p[1], p[2]);
  };
  const size_t kept = std::min(order.size(), size_t(most));
  for (size_t i = kept; i < order.size(); ++i)
    result[size_t(order[i])] =
        *std::min_element(order.begin(), order.begin() + std::ptrdiff_t(kept), [&](int a, int b) {
          return glm::distance(place(a), place(order[i])) <
                 glm::distance(place(b), place(order[i]));
        });
  return result;
}

/// The mean weights of a group, at most kBindings of them.
Binding<float> mean_binding(const GaussianSet& set, const CarriedSet& carried,
                            const std::vector<int64_t>& members) {
  std::map<int, float> sum;
  for (const int64_t n : members)
    for (int k = 0; k < kBindings; ++k)
      if (const float node = set.values().at(kNode, n)[k]; node >= 0)
        sum[int(node)] += carried.weights(n)[k];
  std::vector<std::pair<int, float>> order(sum.begin(), sum.end());
  std::stable_sort(order.begin(), order.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  order.resize(std::min(order.size(), size_t(kBindings)));
  float total = 0;
  for (const auto& [node, weight] : order) total += weight;
  Binding<float> binding;
  for (size_t k = 0; k < size_t(kBindings); ++k) {
    binding.node[k] = k < order.size() ? order[k].first : -1;
    binding.weight[k] = k < order.size() ? order[k].second / total : 0;
  }
  return binding;
}

struct Motion {
  std::vector<RigidGroup> groups;
  std::vector<double> error;  // of each group: Σ over members and times of squared distances
};

/// Rotations by the mean weights; translations by the mean of the members, which has the least
/// error of all.
Motion motion_of(const GaussianSet& set, CarriedSet& carried, const Members& members,
                 const std::vector<double>& times) {
  const size_t count = members.size(), reference = times.size() / 2;
  Motion motion{std::vector<RigidGroup>(count), std::vector<double>(count)};
  carried.at(times[reference]);
  std::vector<Binding<float>> bindings(count);
  std::vector<Vec3<double>> at_reference(size_t(set.count()));
  for (size_t g = 0; g < count; ++g) {
    motion.groups[g].members = members[g];
    bindings[g] = mean_binding(set, carried, members[g]);
    for (const int64_t n : members[g]) at_reference[size_t(n)] = carried.mean(n);
  }
  const auto turn_now = [&](size_t g) {
    const Vec4<double> turn(blend_poses(bindings[g], carried.poses()).turn);
    return dot(turn, turn) > 0 ? normalised(turn) : Vec4<double>(1, 0, 0, 0);
  };
  const auto centre = [&](size_t g, const auto& mean) {
    Vec3<double> sum(0.0);
    for (const int64_t n : members[g]) sum += mean(n);
    return sum / double(members[g].size());
  };
  std::vector<Vec4<double>> turn0(count);
  std::vector<Vec3<double>> centre0(count);
  for (size_t g = 0; g < count; ++g) {
    turn0[g] = turn_now(g);
    centre0[g] = centre(g, [&](int64_t n) { return at_reference[size_t(n)]; });
  }
  for (const double time : times) {
    carried.at(time);
    for (size_t g = 0; g < count; ++g) {
      std::vector<RigidPose>& poses = motion.groups[g].poses;
      RigidPose pose;
      pose.rotation = normalised(quaternion_product(turn_now(g), conjugate(turn0[g])));
      if (dot(pose.rotation, poses.empty() ? Vec4<double>(1, 0, 0, 0) : poses.back().rotation) < 0)
        pose.rotation = pose.rotation * -1.0;
      pose.translation = centre(g, [&](int64_t n) { return carried.mean(n); });
      const Mat3<double> rotation = rotation_matrix(pose.rotation);
      for (const int64_t n : members[g]) {
        const Vec3<double> shown =
            rotation * (at_reference[size_t(n)] - centre0[g]) + pose.translation;
        motion.error[g] += dot(shown - carried.mean(n), shown - carried.mean(n));
      }
      poses.push_back(pose);
    }
  }
  return motion;
}

/// Members of whole groups, and of the parts of each.
struct Partition {
  Members whole, parts;
  std::vector<size_t> whole_of;  // of each part
};

Partition partition(const GaussianSet& set, const MotionNodes& nodes, const CarriedSet& carried,
                    int64_t most, std::vector<int64_t>& fixed) {
  std::vector<Heaviest> of(size_t(set.count()));
  std::vector<int64_t> size(size_t(nodes.count));
  for (int64_t n = 0; n < set.count(); ++n) {
    of[size_t(n)] = heaviest(set.values().at(kNode, n), carried.weights(n));
    if (of[size_t(n)].first >= 0) ++size[size_t(of[size_t(n)].first)];
  }
  const std::vector<int> merged = merged_nodes(size, nodes, most);
  std::map<int, std::map<int, std::vector<int64_t>>> tree;  // group, second node or −1
  for (int64_t n = 0; n < set.count(); ++n) {
    const Heaviest& h = of[size_t(n)];
    if (h.first < 0)
      fixed.push_back(n);
    else
      tree[merged[size_t(h.first)]][h.weight < kDominant ? h.second : -1].push_back(n);
  }
  Partition p;
  for (const auto& [node, parts] : tree) {
    std::vector<int64_t>& whole = p.whole.emplace_back();
    for (const auto& [second, members] : parts) {
      whole.insert(whole.end(), members.begin(), members.end());
      p.parts.push_back(members);
      p.whole_of.push_back(p.whole.size() - 1);
    }
    std::sort(whole.begin(), whole.end());
  }
  return p;
}

double extent_of(const GaussianSet& set) {
  Vec3<float> low(INFINITY), high(-INFINITY);
  for (int64_t n = 0; n < set.count(); ++n)
    for (int k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], set.values().at(kMean, n)[k]);
      high[k] = std::max(high[k], set.values().at(kMean, n)[k]);
    }
  return set.count() > 0 ? double(glm::length(high - low)) : 0;
}

/// Whole groups, or the parts of those that gain most by it, as long as there is room.
Motion chosen(const Motion& whole, const Motion& parts, const Partition& p, double least_gain,
              int64_t most) {
  std::vector<double> gain = whole.error;
  std::vector<int64_t> pieces(gain.size());
  for (size_t i = 0; i < p.parts.size(); ++i) {
    gain[p.whole_of[i]] -= parts.error[i];
    ++pieces[p.whole_of[i]];
  }
  std::vector<size_t> order(gain.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return gain[a] > gain[b]; });
  std::vector<bool> split(gain.size());
  auto count = int64_t(gain.size());
  for (const size_t g : order) {
    const double least = least_gain * double(whole.groups[g].members.size());
    if (pieces[g] < 2 || !(gain[g] > least) || count + pieces[g] - 1 > most) continue;
    split[g] = true;
    count += pieces[g] - 1;
  }
  Motion motion;
  const auto add = [&](const Motion& from, size_t i) {
    motion.groups.push_back(from.groups[i]);
    motion.error.push_back(from.error[i]);
  };
  for (size_t g = 0; g < gain.size(); ++g)
    if (!split[g]) add(whole, g);
  for (size_t i = 0; i < p.parts.size(); ++i)
    if (split[p.whole_of[i]]) add(parts, i);
  return motion;
}

}  // namespace

RigidGroups rigid_groups(const GaussianSet& set, const MotionNodes& nodes,
                         const std::vector<double>& times, int64_t most) {
  check(set.form() == SetForm::kCanonical && !times.empty() && most > 0,
        "rigid_groups: a canonical set, times and room for a group");
  RigidGroups result;
  CarriedSet carried(set, nodes);
  const size_t reference = times.size() / 2;
  carried.at(times[reference]);
  const Partition p = partition(set, nodes, carried, most, result.fixed);
  const double gain = kLeastGain * extent_of(set);
  Motion motion =
      chosen(motion_of(set, carried, p.whole, times), motion_of(set, carried, p.parts, times), p,
             gain * gain * double(times.size()), most);
  result.groups = std::move(motion.groups);
  const auto moving = double(set.count() - int64_t(result.fixed.size()));
  const double error = std::accumulate(motion.error.begin(), motion.error.end(), 0.0);
  if (moving > 0) result.rms_error = std::sqrt(error / (moving * double(times.size())));

  result.local = GaussianSet(SetForm::kStatic, set.coefficients());
  result.local.resize(set.count());
  for (const Group g : {kMean, kLogScale, kRotation, kOpacityLogit, kSh})
    std::copy(set.group(g).value.begin(), set.group(g).value.end(),
              result.local.group(g).value.begin());
  const GaussianSpans<float> local = result.local.values();
  carried.at(times[reference]);
  for (const RigidGroup& group : result.groups)
    for (const int64_t n : group.members) {
      const Vec3<double> mean = carried.mean(n) - group.poses[reference].translation;
      const Vec4<float> rotation = normalised(carried.rotation(n));
      for (int k = 0; k < 3; ++k) local.at(kMean, n)[k] = float(mean[k]);
      for (int k = 0; k < 4; ++k) local.at(kRotation, n)[k] = rotation[k];
    }
  return result;
}

}  // namespace tessera
