// What: lists of neighbours made mutual, and copied to where the kernels read them.
// Not: the search (nearest_points.h).
#include "recon4d/training/rigidity.h"

#include <algorithm>
#include <cmath>

#include "recon4d/training/nearest_points.h"

namespace tessera {
namespace {

using Lists = std::vector<std::vector<Neighbour>>;

struct End {
  int32_t other;
  float affinity;
};

/// The nearest of those that are finite, numbered as `means` are.
Lists finite_neighbours(const std::vector<glm::vec3>& means) {
  std::vector<int32_t> rows;
  std::vector<glm::vec3> finite;
  for (size_t n = 0; n < means.size(); ++n)
    if (std::isfinite(means[n].x + means[n].y + means[n].z))
      rows.push_back(int32_t(n)), finite.push_back(means[n]);
  Lists lists(means.size()), found = nearest_neighbours(finite);
  for (size_t i = 0; i < rows.size(); ++i) {
    for (Neighbour& neighbour : found[i]) neighbour.point = rows[size_t(neighbour.point)];
    lists[size_t(rows[i])] = std::move(found[i]);
  }
  return lists;
}

/// h, world units.
double mean_distance(const Lists& lists) {
  double sum = 0;
  int64_t count = 0;
  for (const std::vector<Neighbour>& list : lists)
    for (const Neighbour& neighbour : list) sum += std::sqrt(double(neighbour.squared)), ++count;
  return count > 0 ? sum / double(count) : 0;
}

/// The ends that meet in one Gaussian, each other one once.
void merge(std::vector<End>& ends) {
  std::sort(ends.begin(), ends.end(), [](const End& a, const End& b) { return a.other < b.other; });
  size_t kept = 0;
  for (size_t k = 0; k < ends.size(); ++k)
    if (kept > 0 && ends[kept - 1].other == ends[k].other)
      ends[kept - 1].affinity += ends[k].affinity;
    else
      ends[kept++] = ends[k];
  ends.resize(kept);
}

template <class T>
void store(const std::vector<T>& values, Buffer<T>& to) {
  to.resize(int64_t(values.size()));
  if (!values.empty()) to.memory().copy(to.data(), values.data(), sizeof(T) * values.size());
}

}  // namespace

RigidityLists rigidity_lists(const std::vector<glm::vec3>& means, Memory& memory) {
  const Lists lists = finite_neighbours(means);
  const double h = mean_distance(lists);
  const double share = 1 / (double(kNeighbours) * double(std::max<size_t>(means.size(), 1)));
  std::vector<std::vector<End>> ends(means.size());
  for (size_t i = 0; i < lists.size(); ++i)
    for (const Neighbour& j : lists[i]) {
      const double exponent = h > 0 ? -double(j.squared) / (2 * h * h) : 0;
      const float affinity = float(share * std::exp(exponent));
      ends[i].push_back({j.point, affinity});
      ends[size_t(j.point)].push_back({int32_t(i), affinity});
    }
  std::vector<int64_t> first{0};
  std::vector<int32_t> other;
  std::vector<float> affinity;
  for (std::vector<End>& of_one : ends) {
    merge(of_one);
    for (const End& end : of_one) other.push_back(end.other), affinity.push_back(end.affinity);
    first.push_back(int64_t(other.size()));
    std::vector<End>().swap(of_one);
  }
  RigidityLists out(memory);
  store(first, out.first), store(other, out.other), store(affinity, out.affinity);
  return out;
}

}  // namespace tessera
