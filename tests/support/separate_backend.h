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
  /// The pages are open as long as the result is there.
  auto open() {
    if (depth_++ == 0) protect();
    const auto close = [this](void*) {
      if (--depth_ == 0) protect();
    };
    return std::unique_ptr<void, decltype(close)>(this, close);
  }
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
    const auto opened = open();
    std::memcpy(to, from, bytes);
  }
  /// Done no earlier than it must be.
  void copy_async_in(void* to, const void* from, size_t bytes) override {
    ++async_copies;
    late_.push_back([to, from, bytes] { std::memcpy(to, from, bytes); });
  }
  void wait_copies() override {
    const auto opened = open();
    for (const auto& copy : late_) copy();
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

  template <class Work>
  void inside(Work&& work) {
    const auto opened = open();
    work();
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
  using Real = float;
  SeparateMemory separate_memory;
  std::vector<std::string> calls;  // of kRecorded
  int64_t strays = 0;              // spans handed in that lie elsewhere

  std::string name() const override { return "separate " + cpu_->name(); }
  Memory& memory() override { return separate_memory; }
  StageClock& clock() override { return cpu_->clock(); }
#define OPERATION(result, name, parameters, names) \
  result name parameters override {                \
    record(#name);                                 \
    look_at names;                                 \
    const auto opened = separate_memory.open();    \
    return cpu_->name names;                       \
  }
#include "kernels/operations.inc"

 private:
  void record(const std::string& name) {
    // the operations that wait, and project_backward
    static const std::set<std::string> kRecorded{"project",         "sum_of_squares",
                                                 "outcome",         "project_backward",
                                                 "select_elements", "relocate_elements"};
    if (kRecorded.contains(name)) calls.push_back(name);
  }

  template <class... Arguments>
  void look_at(const Arguments&... arguments) {
    (look(arguments), ...);
  }
  /// Of what has no spans of the caller.
  template <class T>
  void look(const T&) {}
  template <class T>
  void look(const Span<T>& span) {
    strays += !span.empty() && !separate_memory.holds(span.data);
  }
  template <class T>
  void look(const std::vector<Span<T>>& spans) {
    for (const Span<T>& span : spans) look(span);
  }
  template <class T>
  void look(const GaussianSpans<T>& set) {
    for (const Span<T>& group : set.group) look(group);
    look(set.filter_size);
  }
  template <class T>
  void look(const NodeSpans<T>& nodes) {
    look_at(nodes.position, nodes.log_radius, nodes.translation, nodes.rotation);
  }
  template <class T>
  void look(const DensityStatistics<T>& statistics) {
    look_at(statistics.gradient_sum, statistics.count);
  }
  void look(const SinkArgs<float>& sink) {
    look_at(sink.value, sink.gradient, sink.moment1, sink.moment2);
  }
  void look(const CarryArgs<float>& args) {
    look_at(args.set, args.nodes);
  }
  void look(const CarryBackwardArgs<float>& args) {
    look_at(args.d_carried, args.d_nodes);
  }
  void look(const ProjectArgs<float>& args) {
    look_at(args.sets[0], args.sets[1]);
  }
  void look(const EnvironmentArgs<float>& args) {
    look(args.map);
  }
  void look(const ColourMapArgs<float>& args) {
    look(args.colour);
  }
  void look(const PhotometricArgs<float>& args) {
    look_at(args.colour, args.truth, args.mask);
  }
  void look(const BlendBackwardArgs<float>& args) {
    look_at(args.d_colour, args.lengths);
  }
  void look(const SensitivityArgs<float>& args) {
    look_at(args.pass, args.mask);
  }
  void look(const ContributionArgs<float>& args) {
    look_at(args.sums, args.elements, args.variation);
  }
  void look(const DemoteArgs<float>& args) {
    look_at(args.from, args.timestep, args.opacity, args.to);
  }
  void look(const MissedArgs<float>& args) {
    look_at(args.residual, args.mask);
  }
  void look(const VoteArgs<float>& args) {
    look(args.missed);
  }
  void look(const ProjectBackwardArgs<float>& args) {
    look_at(args.sinks[0], args.sinks[1], args.statistics[0], args.statistics[1]);
  }
  void look(const FilterArgs<float>& args) {
    look(args.set);
  }

  std::unique_ptr<Backend> cpu_ = make_cpu_backend();
};

}  // namespace tessera::testing
