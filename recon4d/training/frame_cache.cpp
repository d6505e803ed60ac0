// What: frames → the backend's memory, once or ahead of the steps.
// Not: the copy itself, which is the memory's.
#include "recon4d/training/frame_cache.h"

#include <fmt/format.h>

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

int64_t aligned(size_t bytes) {
  return (int64_t(bytes) + kAlignment - 1) / kAlignment * kAlignment;
}

void require_frames(const Scene& scene, const std::vector<int>& frames) {
  if (frames.empty())
    throw InputError(
        fmt::format("{}: none of its {} frames belongs to the training split; "
                    "training needs at least one",
                    scene.path, scene.frames.size()));
}

/// What a frame takes: its mask lies behind its image.
int64_t bytes_of(const Frame& frame) {
  return aligned(frame.image.data.size()) + aligned(frame.mask.data.size());
}

Span<const uint8_t> span_of(const uint8_t* begin, const Image8& image) {
  return {image.data.empty() ? nullptr : begin, int64_t(image.data.size())};
}

/// A frame that copy_frame copied to `bytes`.
void append_copied(const Frame& frame, const uint8_t* bytes, TargetImages& fed) {
  fed.images.push_back(span_of(bytes, frame.image));
  fed.masks.push_back(span_of(bytes + aligned(frame.image.data.size()), frame.mask));
}

}  // namespace

std::vector<int> training_frames(const Scene& scene) {
  std::vector<int> frames = scene.split_indices(Split::kTrain);
  require_frames(scene, frames);
  return frames;
}

FrameCache::FrameCache(Memory& memory, const Scene& scene, std::vector<int> frames, int64_t budget,
                       int64_t batch)
    : memory_(memory), scene_(scene), frames_(std::move(frames)), resident_(memory) {
  require_frames(scene_, frames_);
  if (&memory_ == &host_memory()) return;
  int64_t all = 0, largest = 0;
  for (int64_t i = 0; i < int64_t(frames_.size()); ++i) {
    const int64_t bytes = bytes_of(frame(i));
    offset_.push_back(all);
    all += bytes;
    largest = std::max(largest, bytes);
  }
  const int64_t free_bytes = memory_.free_bytes();
  if (all <= (budget > 0 ? budget : free_bytes - reserve_of(free_bytes))) {
    upload_all();
    return;
  }
  place_ = Place::kRing;
  for (const int place : frames_) {  // so that a copy does not hold the host up
    const Frame& frame = scene_.frames[size_t(place)];
    memory_.pin(frame.image.data.data(), frame.image.data.size());
    if (!frame.mask.data.empty()) memory_.pin(frame.mask.data.data(), frame.mask.data.size());
  }
  for (int64_t i = 0; i < kSlots; ++i) {
    slots_.emplace_back(memory_);
    slots_.back().bytes.resize(batch * largest);
  }
}

FrameCache::~FrameCache() {
  if (place_ != Place::kRing) return;
  for (const int place : frames_) {
    const Frame& frame = scene_.frames[size_t(place)];
    memory_.unpin(frame.image.data.data());
    if (!frame.mask.data.empty()) memory_.unpin(frame.mask.data.data());
  }
}

void FrameCache::copy_frame(int64_t index, uint8_t* to) {
  const std::vector<uint8_t>&image = frame(index).image.data, &mask = frame(index).mask.data;
  memory_.copy_async_in(to, image.data(), image.size());
  if (!mask.empty()) memory_.copy_async_in(to + aligned(image.size()), mask.data(), mask.size());
}

void FrameCache::upload_all() {
  place_ = Place::kResident;
  const auto count = int64_t(frames_.size());
  resident_.resize(offset_.back() + bytes_of(frame(count - 1)));
  for (int64_t i = 0; i < count; ++i) copy_frame(i, resident_.data() + offset_[size_t(i)]);
  memory_.wait_copies();
}

TargetImages FrameCache::truth(const std::vector<int64_t>& indices) {
  TargetImages fed;
  if (place_ == Place::kRing) {
    current_ = indices;
    if (find(indices) == nullptr) fill(slots_.front(), indices);
    memory_.wait_copies();
    const uint8_t* bytes = std::as_const(find(indices)->bytes).data();
    for (const int64_t index : indices) {
      append_copied(frame(index), bytes, fed);
      bytes += bytes_of(frame(index));
    }
    return fed;
  }
  for (const int64_t index : indices) {
    const Frame& of_host = frame(index);
    if (place_ == Place::kResident) {
      append_copied(of_host, std::as_const(resident_).data() + offset_[size_t(index)], fed);
      continue;
    }
    fed.images.push_back(span_of(of_host.image.data.data(), of_host.image));
    fed.masks.push_back(span_of(of_host.mask.data.data(), of_host.mask));
  }
  return fed;
}

void FrameCache::prefetch(const std::vector<std::vector<int64_t>>& upcoming) {
  if (place_ != Place::kRing) return;
  const auto wanted = [&](const Slot& slot) {
    return slot.indices == current_ ||
           std::find(upcoming.begin(), upcoming.end(), slot.indices) != upcoming.end();
  };
  for (const std::vector<int64_t>& indices : upcoming) {
    if (find(indices) != nullptr) continue;
    const auto done = std::find_if_not(slots_.begin(), slots_.end(), wanted);
    check(done != slots_.end(), "FrameCache: more batches ahead than it has room for");
    fill(*done, indices);
  }
}

FrameCache::Slot* FrameCache::find(const std::vector<int64_t>& indices) {
  const auto slot = std::find_if(slots_.begin(), slots_.end(),
                                 [&](const Slot& filled) { return filled.indices == indices; });
  return slot == slots_.end() ? nullptr : &*slot;
}

void FrameCache::fill(Slot& slot, const std::vector<int64_t>& indices) {
  uint8_t* cursor = slot.bytes.data();
  slot.indices = indices;
  for (const int64_t index : indices) {
    copy_frame(index, cursor);
    cursor += bytes_of(frame(index));
  }
}

}  // namespace tessera
