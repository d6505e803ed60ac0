// The CPU backend with a memory of its own that the rest of the program cannot access, like a
// device's: its pages are protected except during a stage or a copy. An access from outside ends
// the test with a segmentation fault.
#pragma once
#include <sys/mman.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <iterator>
#include <map>
#include <memory>
#include <new>
#include <set>
#include <string>
#include <vector>

#include "kernels/backend.h"
#include "kernels/base/errors.h"

namespace tessera::testing {

class SeparateMemory final : public Memory {
 public:
  void* allocate(size_t bytes) override {
    const size_t length = std::max<size_t>(bytes, 1);
    void* pages = mmap(nullptr, length, rights(), MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (pages == MAP_FAILED) throw std::bad_alloc();
    lengths_[pages] = length;
    held_ += int64_t(length);
    peak_ = std::max(peak_, held_);
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
  /// Twice is refused, as a device does.
  void pin(const void* begin, size_t) override {
    check(pinned_.insert(begin).second, "these bytes are pinned already");
  }
  void unpin(const void* begin) override {
    check(pinned_.erase(begin) == 1, "these bytes are not pinned");
  }
  size_t pinned() const { return pinned_.size(); }
  int64_t free_bytes() const override { return free; }
  int64_t peak_bytes() const override { return peak_; }
  void trim() override { buffers_at_trim.push_back(buffers()); }

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
  std::vector<int64_t> buffers_at_trim;

 private:
  int rights() const { return depth_ > 0 ? PROT_READ | PROT_WRITE : PROT_NONE; }
  void protect() {
    for (const auto& [pages, length] : lengths_) mprotect(pages, length, rights());
  }

  std::map<void*, size_t> lengths_;
  std::set<const void*> pinned_;
  std::vector<std::function<void()>> late_;
  int depth_ = 0;
  int64_t held_ = 0, peak_ = 0;  // bytes
};

class SeparateBackend final : public Backend {
 public:
  SeparateMemory separate_memory;
  std::vector<std::string> calls;  // of the stages that wait, and of project_backward
  int64_t strays = 0;              // spans handed in that lie elsewhere

  std::string name() const override { return "separate " + cpu_->name(); }
  Memory& memory() override { return separate_memory; }
  StageClock& clock() override { return cpu_->clock(); }
  void carry(const CarryArgs<float>& args, Carried<float>& carried) override {
    check_lies_here(args.set);
    check_lies_here(args.nodes);
    separate_memory.inside([&] { cpu_->carry(args, carried); });
  }
  void carry_backward(const CarryBackwardArgs<float>& args) override {
    check_lies_here(args.d_carried);
    check_lies_here(args.d_nodes);
    separate_memory.inside([&] { cpu_->carry_backward(args); });
  }
  void project(const ProjectArgs<float>& args, Splats<float>& splats) override {
    calls.push_back("project");
    for (int k = 0; k < 2; ++k) check_lies_here(args.sets[k]);
    separate_memory.inside([&] { cpu_->project(args, splats); });
  }
  void bin(const BinArgs<float>& args, TileInstances<float>& instances) override {
    separate_memory.inside([&] { cpu_->bin(args, instances); });
  }
  void blend(const BlendArgs<float>& args, Images<float>& images) override {
    separate_memory.inside([&] { cpu_->blend(args, images); });
  }
  void environment(const EnvironmentArgs<float>& args, Images<float>& images) override {
    check_lies_here(args.map);
    separate_memory.inside([&] { cpu_->environment(args, images); });
  }
  void environment_backward(const EnvironmentArgs<float>& args, const Images<float>& images,
                            Span<const float> d_colour, Span<float> d_map) override {
    check_lies_here(args.map);
    check_lies_here(d_map);
    separate_memory.inside([&] { cpu_->environment_backward(args, images, d_colour, d_map); });
  }
  void map_colours(const ColourMapArgs<float>& args, Span<float> mapped) override {
    check_lies_here(args.colour);
    check_lies_here(mapped);
    separate_memory.inside([&] { cpu_->map_colours(args, mapped); });
  }
  void map_colours_backward(const ColourMapArgs<float>& args, Span<float> d_colour) override {
    check_lies_here(args.colour);
    check_lies_here(d_colour);
    separate_memory.inside([&] { cpu_->map_colours_backward(args, d_colour); });
  }
  void photometric(const PhotometricArgs<float>& args, Span<float> d_colour) override {
    check_lies_here(args.colour);
    for (const Span<const uint8_t>& truth : args.truth) check_lies_here(truth);
    for (const Span<const uint8_t>& mask : args.mask) check_lies_here(mask);
    separate_memory.inside([&] { cpu_->photometric(args, d_colour); });
  }
  void residual(const PhotometricArgs<float>& args, Span<float> residual) override {
    for (const Span<const uint8_t>& truth : args.truth) check_lies_here(truth);
    for (const Span<const uint8_t>& mask : args.mask) check_lies_here(mask);
    check_lies_here(residual);
    separate_memory.inside([&] { cpu_->residual(args, residual); });
  }
  void sensitivity(const SensitivityArgs<float>& args, Span<SplatSensitivity<float>> out) override {
    check_lies_here(args.pass.d_colour);
    check_lies_here(out);
    for (const Span<const uint8_t>& mask : args.mask) check_lies_here(mask);
    separate_memory.inside([&] { cpu_->sensitivity(args, out); });
  }
  void blend_backward(const BlendBackwardArgs<float>& args,
                      Span<SplatMoments<float>> d_splats) override {
    separate_memory.inside([&] { cpu_->blend_backward(args, d_splats); });
  }
  void largest_weights(const BlendArgs<float>& forward, const Images<float>& images,
                       Span<float> elements) override {
    check_lies_here(elements);
    separate_memory.inside([&] { cpu_->largest_weights(forward, images, elements); });
  }
  void contributions(const ContributionArgs<float>& args) override {
    check_lies_here(args.sums);
    check_lies_here(args.elements);
    check_lies_here(args.variation);
    separate_memory.inside([&] { cpu_->contributions(args); });
  }
  void demote(const DemoteArgs<float>& args) override {
    check_lies_here(args.from);
    check_lies_here(args.timestep);
    check_lies_here(args.opacity);
    check_lies_here(args.to);
    separate_memory.inside([&] { cpu_->demote(args); });
  }
  void added_squares(const ViewBatch<float>& batch, Span<const float> before,
                     Span<float> residual) override {
    check_lies_here(before);
    check_lies_here(residual);
    separate_memory.inside([&] { cpu_->added_squares(batch, before, residual); });
  }
  void missed_pixels(const MissedArgs<float>& args, Span<uint8_t> missed) override {
    check_lies_here(args.residual);
    for (const Span<const uint8_t>& mask : args.mask) check_lies_here(mask);
    check_lies_here(missed);
    separate_memory.inside([&] { cpu_->missed_pixels(args, missed); });
  }
  void residual_votes(const VoteArgs<float>& args, Span<float> votes) override {
    check_lies_here(args.missed);
    check_lies_here(votes);
    separate_memory.inside([&] { cpu_->residual_votes(args, votes); });
  }
  double sum_of_squares(Span<const float> values) override {
    calls.push_back("sum_of_squares");
    check_lies_here(values);
    double sum = 0;
    separate_memory.inside([&] { sum = cpu_->sum_of_squares(values); });
    return sum;
  }
  void project_backward(const ProjectBackwardArgs<float>& args) override {
    calls.push_back("project_backward");
    for (int k = 0; k < 2; ++k) {
      check_lies_here(args.sinks[k]);
      check_lies_here(args.statistics[k].gradient_sum);
      check_lies_here(args.statistics[k].count);
    }
    separate_memory.inside([&] { cpu_->project_backward(args); });
  }
  StepOutcome outcome() override {
    calls.push_back("outcome");
    return cpu_->outcome();
  }
  void adam(const SinkArgs<float>& args) override {
    check_lies_here(args);
    separate_memory.inside([&] { cpu_->adam(args); });
  }
  void adam_values(Span<const float> gradient, const AdamScalars<float>& adam, Span<float> value,
                   Span<float> moment1, Span<float> moment2) override {
    check_lies_here(gradient);
    check_lies_here(value);
    separate_memory.inside([&] { cpu_->adam_values(gradient, adam, value, moment1, moment2); });
  }
  void gather_elements(Span<const float> from, Span<const int64_t> index, int width,
                       int64_t inherited, Span<float> to) override {
    check_lies_here(from);
    check_lies_here(index);
    check_lies_here(to);
    separate_memory.inside([&] { cpu_->gather_elements(from, index, width, inherited, to); });
  }
  void select_elements(const GaussianSpans<const float>& set,
                       const DensityStatistics<const float>& statistics, const DensityRule& rule,
                       DensityElements& elements) override {
    calls.push_back("select_elements");
    check_lies_here(statistics.gradient_sum);
    check_lies_here(statistics.count);
    separate_memory.inside([&] { cpu_->select_elements(set, statistics, rule, elements); });
  }
  double growth_weight(const GaussianSpans<const float>& set,
                       const DensityStatistics<const float>& statistics,
                       const DensityRule& rule) override {
    check_lies_here(statistics.gradient_sum);
    double weight = 0;
    separate_memory.inside([&] { weight = cpu_->growth_weight(set, statistics, rule); });
    return weight;
  }
  void place_children(const GaussianSpans<float>& set, int64_t first,
                      const SplitRule& rule) override {
    separate_memory.inside([&] { cpu_->place_children(set, first, rule); });
  }
  void relocate_elements(const GaussianSpans<float>& set, const RelocationRule& rule,
                         RelocationElements& elements) override {
    calls.push_back("relocate_elements");
    check_lies_here(set);
    separate_memory.inside([&] { cpu_->relocate_elements(set, rule, elements); });
  }
  void add_position_noise(const GaussianSpans<float>& set, const PositionNoise& noise) override {
    check_lies_here(set);
    separate_memory.inside([&] { cpu_->add_position_noise(set, noise); });
  }
  void locality_order(const GaussianSpans<const float>& set, Buffer<int64_t>& order) override {
    separate_memory.inside([&] { cpu_->locality_order(set, order); });
  }
  void filter_sizes(const FilterArgs<float>& args, Span<float> sizes) override {
    check_lies_here(args.set);
    check_lies_here(sizes);
    separate_memory.inside([&] { cpu_->filter_sizes(args, sizes); });
  }
  void edit_by_filter(FilterEdit edit, const GaussianSpans<float>& set, float limit) override {
    check_lies_here(set);
    separate_memory.inside([&] { cpu_->edit_by_filter(edit, set, limit); });
  }
  void add_to_mean(Span<const float> values, float weight, Span<float> mean) override {
    check_lies_here(values);
    check_lies_here(mean);
    separate_memory.inside([&] { cpu_->add_to_mean(values, weight, mean); });
  }
  void limit_values(Span<float> values, float limit) override {
    check_lies_here(values);
    separate_memory.inside([&] { cpu_->limit_values(values, limit); });
  }
  void fill_zero(Span<float> values) override {
    check_lies_here(values);
    separate_memory.inside([&] { cpu_->fill_zero(values); });
  }

 private:
  template <class T>
  void check_lies_here(const Span<T>& span) {
    strays += !span.empty() && !separate_memory.holds(span.data);
  }
  template <class T>
  void check_lies_here(const GaussianSpans<T>& set) {
    for (const Span<T>& group : set.group) check_lies_here(group);
    check_lies_here(set.filter_size);
  }
  template <class T>
  void check_lies_here(const NodeSpans<T>& nodes) {
    for (const Span<T>& values :
         {nodes.position, nodes.log_radius, nodes.translation, nodes.rotation})
      check_lies_here(values);
  }
  void check_lies_here(const SinkArgs<float>& sink) {
    check_lies_here(sink.value);
    check_lies_here(sink.gradient);
    check_lies_here(sink.moment1);
    check_lies_here(sink.moment2);
  }

  std::unique_ptr<Backend> cpu_ = make_cpu_backend();
};

}  // namespace tessera::testing
