// Copies of frames to the backend's memory, once or ahead of the steps, and masks of moving pixels.
#include "recon4d/training/frame_cache.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "kernels/base/errors.h"
#include "kernels/math/photometric.h"
#include "recon4d/evaluation/metrics.h"
#include "recon4d/evaluation/temporal_scores.h"

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

Span<const uint8_t> span_of(const uint8_t* begin, const std::vector<uint8_t>& data) {
  return {data.empty() ? nullptr : begin, int64_t(data.size())};
}

}  // namespace

std::vector<int> training_frames(const Scene& scene) {
  std::vector<int> frames = scene.split_indices(Split::kTrain);
  require_frames(scene, frames);
  return frames;
}

FrameCache::FrameCache(Memory& memory, const Scene& scene, std::vector<int> frames, int64_t budget,
                       int64_t batch, FrameMasks masks)
    : memory_(memory),
      scene_(scene),
      frames_(std::move(frames)),
      masks_(std::move(masks)),
      resident_(memory) {
  require_frames(scene_, frames_);
  check(masks_.empty() || masks_.size() == frames_.size(), "FrameCache: one mask a frame");
  if (&memory_ == &host_memory()) return;
  int64_t all = 0, largest = 0;
  for (int64_t i = 0; i < int64_t(frames_.size()); ++i) {
    const int64_t bytes = bytes_of(i);
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
  for (int64_t i = 0; i < int64_t(frames_.size());
       ++i) {  // so that a copy does not hold the host up
    memory_.pin(frame(i).image.data.data(), frame(i).image.data.size());
    if (!mask(i).empty()) memory_.pin(mask(i).data(), mask(i).size());
  }
  for (int64_t i = 0; i < kSlots; ++i) {
    slots_.emplace_back(memory_);
    slots_.back().bytes.resize(batch * largest);
  }
}

FrameCache::~FrameCache() {
  if (place_ != Place::kRing) return;
  for (int64_t i = 0; i < int64_t(frames_.size()); ++i) {
    memory_.unpin(frame(i).image.data.data());
    if (!mask(i).empty()) memory_.unpin(mask(i).data());
  }
}

int64_t FrameCache::bytes_of(int64_t index) const {
  return aligned(frame(index).image.data.size()) + aligned(mask(index).size());
}

void FrameCache::append_copied(int64_t index, const uint8_t* bytes, TargetImages& fed) const {
  const std::vector<uint8_t>& image = frame(index).image.data;
  fed.images.push_back(span_of(bytes, image));
  fed.masks.push_back(span_of(bytes + aligned(image.size()), mask(index)));
}

void FrameCache::copy_frame(int64_t index, uint8_t* to) {
  const std::vector<uint8_t>&image = frame(index).image.data, &mask = this->mask(index);
  memory_.copy_async_in(to, image.data(), image.size());
  if (!mask.empty()) memory_.copy_async_in(to + aligned(image.size()), mask.data(), mask.size());
}

void FrameCache::upload_all() {
  place_ = Place::kResident;
  const auto count = int64_t(frames_.size());
  resident_.resize(offset_.back() + bytes_of(count - 1));
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
      append_copied(index, bytes, fed);
      bytes += bytes_of(index);
    }
    return fed;
  }
  for (const int64_t index : indices) {
    if (place_ == Place::kResident) {
      append_copied(index, std::as_const(resident_).data() + offset_[size_t(index)], fed);
      continue;
    }
    const std::vector<uint8_t>& image = frame(index).image.data;
    fed.images.push_back(span_of(image.data(), image));
    fed.masks.push_back(span_of(mask(index).data(), mask(index)));
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
    cursor += bytes_of(index);
  }
}

FrameMasks moving_masks(const Scene& scene, const std::vector<int>& frames) {
  FrameMasks masks;
  DynamicRegions regions(scene, DynamicRegions::Of::kTrainingFrames);
  for (const int place : frames) {
    const Frame& frame = scene.frames[size_t(place)];
    const Span<const uint8_t> frame_mask = used_mask(frame);
    std::vector<uint8_t>& mask = masks.emplace_back(regions.mask_of(frame));
    if (mask.empty() && !frame_mask.empty()) mask.assign(size_t(frame_mask.size), 0);
    for (size_t p = 0; p < mask.size(); ++p)
      mask[p] = !is_used(frame_mask, p) ? 0 : mask[p] != 0 ? kMovingPixel : 1;
  }
  return masks;
}

}  // namespace tessera
