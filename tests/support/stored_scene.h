// The values of a test copied to the memory of a backend and back: arrays, Gaussians, scenes.
#pragma once
#include "kernels/pipeline.h"
#include "tests/support/test_scene.h"

namespace tessera::testing {

template <class T>
Buffer<T> stored(const std::vector<T>& values, Memory& memory) {
  Buffer<T> buffer(int64_t(values.size()), memory);
  if (!values.empty()) memory.copy(buffer.data(), values.data(), sizeof(T) * values.size());
  return buffer;
}

template <class T>
void store_over(const std::vector<T>& values, Span<T> to, Memory& memory) {
  if (!values.empty()) memory.copy(to.data, values.data(), sizeof(T) * values.size());
}

/// A copy on the host.
template <class T>
std::vector<std::remove_const_t<T>> fetched(Span<T> values, Memory& memory) {
  std::vector<std::remove_const_t<T>> out(size_t(values.size));
  if (!out.empty()) memory.copy(out.data(), values.data, sizeof(T) * out.size());
  return out;
}
template <class T>
std::vector<T> fetched(const Buffer<T>& values, Memory& memory) {
  return fetched(values.span(), memory);
}

/// TestGaussians in a backend's memory.
template <class Real>
class StoredGaussians {
 public:
  StoredGaussians(const TestGaussians<Real>& set, Memory& memory)
      : memory_(memory),
        form_(set.form),
        count_(set.count),
        coefficients_(set.coefficients),
        time_levels_(set.time_levels),
        blocks_(set.blocks),
        filter_size_(stored(set.filter_size, memory)) {
    for (int g = 0; g < kGroupCount; ++g) group_[g] = stored(set.group[g], memory);
  }

  GaussianSpans<Real> spans() { return make<Real>(*this); }
  GaussianSpans<const Real> view() const { return make<const Real>(*this); }
  TestGaussians<Real> fetch() const {
    TestGaussians<Real> set(form_, count_, coefficients_, time_levels_, blocks_);
    for (int g = 0; g < kGroupCount; ++g) set.group[g] = fetched(group_[g], memory_);
    set.filter_size = fetched(filter_size_, memory_);
    return set;
  }

 private:
  template <class T, class Self>
  static GaussianSpans<T> make(Self& self) {
    GaussianSpans<T> s;
    s.form = self.form_;
    s.count = self.count_;
    s.coefficients = self.coefficients_;
    s.time_levels = self.time_levels_;
    s.blocks = self.blocks_;
    for (int g = 0; g < kGroupCount; ++g) s.group[g] = self.group_[g].span();
    s.filter_size = self.filter_size_.span();
    return s;
  }

  Memory& memory_;
  SetForm form_;
  int64_t count_;
  int coefficients_, time_levels_;
  ShBlocks blocks_;
  Buffer<Real> group_[kGroupCount];
  Buffer<Real> filter_size_;
};

/// TestNodes in a backend's memory.
template <class Real>
class StoredNodes {
 public:
  StoredNodes(const TestNodes<Real>& nodes, Memory& memory)
      : memory_(memory),
        count_(nodes.count),
        knots_(nodes.knots),
        position_(stored(nodes.position, memory)),
        log_radius_(stored(nodes.log_radius, memory)),
        translation_(stored(nodes.translation, memory)),
        rotation_(stored(nodes.rotation, memory)) {}

  NodeSpans<Real> spans() {
    return {count_,          knots_, position_.span(), log_radius_.span(), translation_.span(),
            rotation_.span()};
  }
  NodeSpans<const Real> view() const {
    return {count_,          knots_, position_.span(), log_radius_.span(), translation_.span(),
            rotation_.span()};
  }
  TestNodes<Real> fetch() const {
    return {count_,
            knots_,
            fetched(position_, memory_),
            fetched(log_radius_, memory_),
            fetched(translation_, memory_),
            fetched(rotation_, memory_)};
  }

 private:
  Memory& memory_;
  int64_t count_;
  int knots_;
  Buffer<Real> position_, log_radius_, translation_, rotation_;
};

/// Parameters and ground truth of a TestScene in a backend's memory.
template <class Real>
struct StoredScene {
  StoredGaussians<Real> sets[2];
  std::vector<Buffer<uint8_t>> truth, mask;
  std::vector<View> views;
  RenderOptions options;
  LossWeights weights;
  std::vector<ColourMap<double>> maps;
  Buffer<Real> environment;
  int environment_height;
  StoredNodes<Real> nodes;

  StoredScene(const TestScene<Real>& scene, Memory& memory)
      : sets{{scene.fixed, memory}, {scene.moving, memory}},
        views(scene.views),
        options(scene.options),
        weights(scene.weights),
        maps(scene.maps),
        environment(stored(scene.environment, memory)),
        environment_height(scene.environment_height),
        nodes(scene.nodes, memory) {
    for (const auto& bytes : scene.truth) truth.push_back(stored(bytes, memory));
    for (const auto& bytes : scene.mask) mask.push_back(stored(bytes, memory));
  }

  /// The rotation of the map of a test.
  static Mat3<Real> turned() {
    const Real c = Real(0.8), s = Real(0.6);
    return Mat3<Real>(1, 0, 0, 0, c, s, 0, -s, c);
  }
  ForwardArgs<Real> forward(bool for_backward) const {
    return {{sets[0].view(), sets[1].view()},
            views,
            options,
            for_backward,
            {nullptr, environment.span(), environment_height, turned()},
            nodes.view()};
  }
  Target target() const {
    Target out;
    out.weights = weights;
    out.maps = maps;
    for (const Buffer<uint8_t>& bytes : truth) out.truth.push_back(bytes.span());
    for (const Buffer<uint8_t>& bytes : mask) out.mask.push_back(bytes.span());
    return out;
  }
};

}  // namespace tessera::testing
