// What: the CPU backend in a memory of its own that the rest of the program cannot touch, as a
//       device's: pages are closed but while a stage or a copy is under way.
// Not: a device: nothing runs behind. A touch from outside ends the test with a segmentation fault.
#pragma once
#include <sys/mman.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <iterator>
#include <map>
#include <memory>
#include <new>
#include <string>
#include <vector>

#include "kernels/backend.h"

namespace tessera::testing {

class SeparateMemory final : public Memory {
 public:
  void* allocate(size_t bytes) override {
    const size_t length = std::max<size_t>(bytes, 1);
    void* pages = mmap(nullptr, length, rights(), MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (pages == MAP_FAILED) throw std::bad_alloc();
    lengths_[pages] = length;
    held_ += int64_t(length), peak_ = std::max(peak_, held_);
    return pages;
  }
  void release(void* pointer, size_t) noexcept override {
    held_ -= int64_t(lengths_.at(pointer));
    munmap(pointer, lengths_.at(pointer));
    lengths_.erase(pointer);
  }
  void copy(void* to, const void* from, size_t bytes) override {
    ++copies;
    copied_bytes += int64_t(bytes);
    inside([&] { std::memcpy(to, from, bytes); });
  }
  /// Done no earlier than it must be.
  void copy_async_in(void* to, const void* from, size_t bytes) override {
    ++async_copies;
    late_.push_back([to, from, bytes] { std::memcpy(to, from, bytes); });
  }
  void wait_copies() override {
    inside([&] {
      for (const auto& copy : late_) copy();
    });
    late_.clear();
  }
  int64_t free_bytes() const override { return free; }
  int64_t peak_bytes() const override { return peak_; }

  /// Opens the pages while `work` runs.
  template <class Work>
  void inside(Work&& work) {
    if (depth_++ == 0) protect();
    work();
    if (--depth_ == 0) protect();
  }
  bool holds(const void* pointer) const {
    const auto after = lengths_.upper_bound(const_cast<void*>(pointer));
    if (after == lengths_.begin()) return false;
    const auto& [begin, length] = *std::prev(after);
    return static_cast<const char*>(pointer) < static_cast<const char*>(begin) + length;
  }
  int64_t buffers() const { return int64_t(lengths_.size()); }

  int64_t free = int64_t{1} << 40;
  int64_t copies = 0, copied_bytes = 0, async_copies = 0;

 private:
  int rights() const { return depth_ > 0 ? PROT_READ | PROT_WRITE : PROT_NONE; }
  void protect() {
    for (const auto& [pages, length] : lengths_) mprotect(pages, length, rights());
  }

  std::map<void*, size_t> lengths_;
  std::vector<std::function<void()>> late_;
  int depth_ = 0;
  int64_t held_ = 0, peak_ = 0;  // bytes
};

class SeparateBackend final : public Backend {
 public:
  SeparateMemory own;
  std::vector<std::string> calls;  // of the stages that wait, and of project_backward
  int64_t strays = 0;              // spans handed in that lie elsewhere

  std::string name() const override { return "separate " + cpu_->name(); }
  Memory& memory() override { return own; }
  StageClock& clock() override { return cpu_->clock(); }
  void project(const ProjectArgs<float>& args, Splats<float>& splats) override {
    calls.push_back("project");
    for (int k = 0; k < 2; ++k) check_lies_here(args.sets[k]);
    own.inside([&] { cpu_->project(args, splats); });
  }
  void bin(const BinArgs<float>& args, TileInstances<float>& instances) override {
    own.inside([&] { cpu_->bin(args, instances); });
  }
  void blend(const BlendArgs<float>& args, Images<float>& images) override {
    own.inside([&] { cpu_->blend(args, images); });
  }
  void environment(const EnvironmentArgs<float>& args, Images<float>& images) override {
    check_lies_here(args.map);
    own.inside([&] { cpu_->environment(args, images); });
  }
  void environment_backward(const EnvironmentArgs<float>& args, const Images<float>& images,
                            Span<const float> d_colour, Span<float> d_map) override {
    check_lies_here(args.map), check_lies_here(d_map);
    own.inside([&] { cpu_->environment_backward(args, images, d_colour, d_map); });
  }
  void photometric(const PhotometricArgs<float>& args, Span<float> d_colour) override {
    for (const Span<const uint8_t>& truth : args.truth) check_lies_here(truth);
    for (const Span<const uint8_t>& mask : args.mask) check_lies_here(mask);
    own.inside([&] { cpu_->photometric(args, d_colour); });
  }
  void residual(const PhotometricArgs<float>& args, Span<float> residual) override {
    for (const Span<const uint8_t>& truth : args.truth) check_lies_here(truth);
    for (const Span<const uint8_t>& mask : args.mask) check_lies_here(mask);
    check_lies_here(residual);
    own.inside([&] { cpu_->residual(args, residual); });
  }
  void sensitivity(const SensitivityArgs<float>& args, Span<SplatSensitivity<float>> out) override {
    check_lies_here(args.pass.d_colour), check_lies_here(out);
    for (const Span<const uint8_t>& mask : args.mask) check_lies_here(mask);
    own.inside([&] { cpu_->sensitivity(args, out); });
  }
  void blend_backward(const BlendBackwardArgs<float>& args,
                      Span<SplatGradient<float>> d_splats) override {
    own.inside([&] { cpu_->blend_backward(args, d_splats); });
  }
  void project_backward(const ProjectBackwardArgs<float>& args) override {
    calls.push_back("project_backward");
    for (int k = 0; k < 2; ++k) {
      check_lies_here(args.sinks[k]);
      check_lies_here(args.statistics[k].gradient_sum);
      check_lies_here(args.statistics[k].count);
    }
    own.inside([&] { cpu_->project_backward(args); });
  }
  StepOutcome outcome() override {
    calls.push_back("outcome");
    return cpu_->outcome();
  }
  void adam(const SinkArgs<float>& args) override {
    check_lies_here(args);
    own.inside([&] { cpu_->adam(args); });
  }
  void adam_values(Span<const float> gradient, const AdamScalars<float>& adam, Span<float> value,
                   Span<float> moment1, Span<float> moment2) override {
    check_lies_here(gradient), check_lies_here(value);
    own.inside([&] { cpu_->adam_values(gradient, adam, value, moment1, moment2); });
  }
  void gather_rows(Span<const float> from, Span<const int64_t> index, int width, int64_t inherited,
                   Span<float> to) override {
    check_lies_here(from), check_lies_here(index), check_lies_here(to);
    own.inside([&] { cpu_->gather_rows(from, index, width, inherited, to); });
  }
  void select_rows(const GaussianSpans<const float>& set,
                   const DensityStatistics<const float>& statistics, const DensityRule& rule,
                   DensityRows& rows) override {
    calls.push_back("select_rows");
    check_lies_here(statistics.gradient_sum), check_lies_here(statistics.count);
    own.inside([&] { cpu_->select_rows(set, statistics, rule, rows); });
  }
  void place_children(const GaussianSpans<float>& set, int64_t first, uint64_t seed) override {
    own.inside([&] { cpu_->place_children(set, first, seed); });
  }
  void relocate_rows(const GaussianSpans<float>& set, const RelocationRule& rule,
                     RelocationRows& rows) override {
    calls.push_back("relocate_rows");
    check_lies_here(set);
    own.inside([&] { cpu_->relocate_rows(set, rule, rows); });
  }
  void add_position_noise(const GaussianSpans<float>& set, const PositionNoise& noise) override {
    check_lies_here(set);
    own.inside([&] { cpu_->add_position_noise(set, noise); });
  }
  void locality_order(const GaussianSpans<const float>& set, Buffer<int64_t>& order) override {
    own.inside([&] { cpu_->locality_order(set, order); });
  }
  void filter_sizes(const FilterArgs<float>& args, Span<float> sizes) override {
    check_lies_here(args.set), check_lies_here(sizes);
    own.inside([&] { cpu_->filter_sizes(args, sizes); });
  }
  void edit_by_filter(FilterEdit edit, const GaussianSpans<float>& set, float limit) override {
    check_lies_here(set);
    own.inside([&] { cpu_->edit_by_filter(edit, set, limit); });
  }
  void limit_values(Span<float> values, float limit) override {
    check_lies_here(values);
    own.inside([&] { cpu_->limit_values(values, limit); });
  }
  void fill_zero(Span<float> values) override {
    check_lies_here(values);
    own.inside([&] { cpu_->fill_zero(values); });
  }

 private:
  template <class T>
  void check_lies_here(const Span<T>& span) {
    strays += !span.empty() && !own.holds(span.data);
  }
  template <class T>
  void check_lies_here(const GaussianSpans<T>& set) {
    for (const Span<T>& group : set.group) check_lies_here(group);
    check_lies_here(set.filter_size);
  }
  void check_lies_here(const SinkArgs<float>& sink) {
    check_lies_here(sink.value), check_lies_here(sink.gradient);
    check_lies_here(sink.moment1), check_lies_here(sink.moment2);
  }

  std::unique_ptr<Backend> cpu_ = make_cpu_backend();
};

}  // namespace tessera::testing
