// What: frames → the backend's memory, once or ahead of the steps.
// Not: the copy itself, which is the memory's.
#include "recon4d/frame_feed.h"

#include <algorithm>
#include <utility>

#include "kernels/base/errors.h"

namespace tessera {
namespace {

/// Bytes left for Gaussians and their splats: a few, or half of a small card.
int64_t reserve_of(int64_t free_bytes) {
  constexpr int64_t kReserve = int64_t{8} << 30;
  return std::min(kReserve, free_bytes / 2);
}
constexpr int64_t kAlignment = 64;  // bytes

int64_t aligned(int64_t bytes) {
  return (bytes + kAlignment - 1) / kAlignment * kAlignment;
}

}  // namespace

FrameFeed::FrameFeed(Memory& memory, const Scene& scene, std::vector<int> frames, int64_t budget,
                     int64_t batch)
    : memory_(memory), scene_(scene), frames_(std::move(frames)), resident_(memory) {
  if (&memory_ == &host_memory()) return;
  int64_t all = 0, largest = 0;
  for (int64_t i = 0; i < int64_t(frames_.size()); ++i) {
    const int64_t bytes = aligned(int64_t(image(i).data.size()));
    offset_.push_back(all);
    all += bytes, largest = std::max(largest, bytes);
  }
  const int64_t free_bytes = memory_.free_bytes();
  if (all <= (budget > 0 ? budget : free_bytes - reserve_of(free_bytes))) {
    upload_all();
    return;
  }
  place_ = Place::kRing;
  for (const int frame : frames_) {  // so that a copy does not hold the host up
    const std::vector<uint8_t>& data = scene_.frames[size_t(frame)].image.data;
    memory_.pin(data.data(), data.size());
  }
  for (int64_t i = 0; i < kSlots; ++i) {
    slots_.emplace_back(memory_);
    slots_.back().bytes.resize(batch * largest);
  }
}

FrameFeed::~FrameFeed() {
  if (place_ != Place::kRing) return;
  for (const int frame : frames_) memory_.unpin(scene_.frames[size_t(frame)].image.data.data());
}

void FrameFeed::upload_all() {
  place_ = Place::kResident;
  const int64_t last = int64_t(frames_.size()) - 1;
  resident_.resize(offset_.back() + int64_t(image(last).data.size()));
  for (int64_t i = 0; i <= last; ++i)
    memory_.copy_async_in(resident_.data() + offset_[size_t(i)], image(i).data.data(),
                          image(i).data.size());
  memory_.wait_copies();
}

std::vector<Span<const uint8_t>> FrameFeed::truth(const std::vector<int64_t>& indices) {
  if (place_ == Place::kRing) {
    current_ = indices;
    if (find(indices) == nullptr) fill(slots_.front(), indices);
    memory_.wait_copies();
    return spans_of(*find(indices));
  }
  std::vector<Span<const uint8_t>> spans;
  for (const int64_t index : indices) {
    const std::vector<uint8_t>& data = image(index).data;
    const uint8_t* begin = place_ == Place::kHost
                               ? data.data()
                               : std::as_const(resident_).data() + offset_[size_t(index)];
    spans.push_back({begin, int64_t(data.size())});
  }
  return spans;
}

void FrameFeed::prefetch(const std::vector<std::vector<int64_t>>& upcoming) {
  if (place_ != Place::kRing) return;
  const auto wanted = [&](const Slot& slot) {
    return slot.indices == current_ ||
           std::find(upcoming.begin(), upcoming.end(), slot.indices) != upcoming.end();
  };
  for (const std::vector<int64_t>& indices : upcoming) {
    if (find(indices) != nullptr) continue;
    const auto done = std::find_if_not(slots_.begin(), slots_.end(), wanted);
    check(done != slots_.end(), "FrameFeed: more batches ahead than it has room for");
    fill(*done, indices);
  }
}

FrameFeed::Slot* FrameFeed::find(const std::vector<int64_t>& indices) {
  const auto slot = std::find_if(slots_.begin(), slots_.end(),
                                 [&](const Slot& filled) { return filled.indices == indices; });
  return slot == slots_.end() ? nullptr : &*slot;
}

void FrameFeed::fill(Slot& slot, const std::vector<int64_t>& indices) {
  int64_t at = 0;
  slot.indices = indices;
  for (const int64_t index : indices) {
    const std::vector<uint8_t>& data = image(index).data;
    memory_.copy_async_in(slot.bytes.data() + at, data.data(), data.size());
    at += aligned(int64_t(data.size()));
  }
}

std::vector<Span<const uint8_t>> FrameFeed::spans_of(const Slot& slot) const {
  std::vector<Span<const uint8_t>> spans;
  int64_t at = 0;
  for (const int64_t index : slot.indices) {
    const int64_t bytes = int64_t(image(index).data.size());
    spans.push_back({slot.bytes.data() + at, bytes});
    at += aligned(bytes);
  }
  return spans;
}

}  // namespace tessera
