// Copies of frames to the backend's memory, once or ahead of the steps, and masks of moving pixels.
#include "recon4d/training/frame_cache.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"
#include "kernels/math/photometric.h"
#include "recon4d/evaluation/dynamic_regions.h"
#include "recon4d/evaluation/metrics.h"

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
  std::vector<int64_t> all(frames_.size());
  std::iota(all.begin(), all.end(), int64_t{0});
  Layout layout = layout_of(all);
  const int64_t free_bytes = memory_.free_bytes();
  if (layout.bytes > (budget > 0 ? budget : free_bytes - reserve_of(free_bytes))) {
    set_up_ring(batch);
    return;
  }
  kept_ = Kept::kResident;
  resident_.resize(layout.bytes);
  copy(all, layout, resident_.data());
  memory_.wait_copies();
  places_ = std::move(layout.places);
}

FrameCache::~FrameCache() {
  for (const uint8_t* pixels : pinned_) memory_.unpin(pixels);
}

void FrameCache::set_up_ring(int64_t batch) {
  kept_ = Kept::kInRing;
  std::set<const uint8_t*> known;
  const auto pin = [&](const std::vector<uint8_t>& pixels) {  // so that a copy does not hold it up
    if (pixels.empty() || !known.insert(pixels.data()).second) return;
    memory_.pin(pixels.data(), pixels.size());
    pinned_.push_back(pixels.data());
  };
  int64_t largest = 0;
  for (int64_t i = 0; i < int64_t(frames_.size()); ++i) {
    pin(frame(i).image.data);
    pin(mask(i).data());
    largest = std::max(largest, layout_of({i}).bytes);
  }
  for (int64_t i = 0; i < kSlots; ++i) {
    slots_.emplace_back(memory_);
    slots_.back().bytes.resize(batch * largest);
  }
}

FrameCache::Layout FrameCache::layout_of(const std::vector<int64_t>& indices) const {
  Layout layout;
  std::map<const Image8*, int64_t> masks;
  const auto next = [&](const std::vector<uint8_t>& pixels) {
    return std::exchange(layout.bytes, layout.bytes + aligned(pixels.size()));
  };
  for (const int64_t index : indices) {
    Place place{next(frame(index).image.data), 0};
    const FrameMask& mask = this->mask(index);
    if (!mask.data().empty()) {
      const auto known = masks.find(mask.shared());
      place.mask = known != masks.end() ? known->second : next(mask.data());
      masks[mask.shared()] = place.mask;
    }
    layout.places.push_back(place);
  }
  return layout;
}

void FrameCache::copy(const std::vector<int64_t>& indices, const Layout& layout, uint8_t* to) {
  std::set<int64_t> masks;
  for (size_t k = 0; k < indices.size(); ++k) {
    const std::vector<uint8_t>&image = frame(indices[k]).image.data,
          &mask = this->mask(indices[k]).data();
    const Place place = layout.places[k];
    memory_.copy_async_in(to + place.image, image.data(), image.size());
    if (!mask.empty() && masks.insert(place.mask).second)
      memory_.copy_async_in(to + place.mask, mask.data(), mask.size());
  }
}

void FrameCache::append(int64_t index, const uint8_t* image, const uint8_t* mask,
                        TargetImages& fed) const {
  fed.images.push_back(span_of(image, frame(index).image.data));
  fed.masks.push_back(span_of(mask, this->mask(index).data()));
}

TargetImages FrameCache::truth(const std::vector<int64_t>& indices) {
  TargetImages fed;
  if (kept_ == Kept::kInRing) {
    current_ = indices;
    if (find(indices) == nullptr) fill(slots_.front(), indices);
    memory_.wait_copies();
    const Slot& slot = *find(indices);
    for (size_t k = 0; k < indices.size(); ++k) {
      const Place place = slot.layout.places[k];
      append(indices[k], slot.bytes.data() + place.image, slot.bytes.data() + place.mask, fed);
    }
    return fed;
  }
  const uint8_t* const resident = std::as_const(resident_).data();
  for (const int64_t index : indices) {
    if (kept_ == Kept::kOnHost) {
      append(index, frame(index).image.data.data(), mask(index).data().data(), fed);
      continue;
    }
    const Place place = places_[size_t(index)];
    append(index, resident + place.image, resident + place.mask, fed);
  }
  return fed;
}

void FrameCache::prefetch(const std::vector<std::vector<int64_t>>& upcoming) {
  if (kept_ != Kept::kInRing) return;
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
  slot.indices = indices;
  slot.layout = layout_of(indices);
  copy(indices, slot.layout, slot.bytes.data());
}

FrameMasks moving_masks(const Scene& scene, const std::vector<int>& frames) {
  FrameMasks masks(frames.size());
  const DynamicRegions regions(scene, DynamicRegions::Of::kTrainingFrames, frames);
  parallel_for(int64_t(frames.size()), 1, [&](int64_t first, int64_t last) {
    for (int64_t i = first; i < last; ++i) {
      const Frame& frame = scene.frames[size_t(frames[size_t(i)])];
      std::vector<uint8_t> mask = regions.mask_of(frame);
      const Span<const uint8_t> used = used_mask(frame);
      for (size_t p = 0; p < mask.size(); ++p)
        mask[p] = !is_used(used, p) ? 0 : mask[p] != 0 ? kMovingPixel : kStillPixel;
      if (!mask.empty())
        masks[size_t(i)] = Image8{frame.image.width, frame.image.height, 1, std::move(mask)};
    }
  });
  std::map<const Image8*, FrameMask> unknown;  // by the masks that frames share
  for (size_t i = 0; i < frames.size(); ++i) {
    const Frame& frame = scene.frames[size_t(frames[i])];
    if (!masks[i].data().empty() || frame.mask.data().empty()) continue;
    FrameMask& shared = unknown[frame.mask.shared()];
    if (shared.data().empty()) {
      Image8 mask = frame.mask.image();
      for (uint8_t& value : mask.data) value = value == 0 ? 0 : kUnknownPixel;
      shared = std::move(mask);
    }
    masks[i] = shared;
  }
  return masks;
}

}  // namespace tessera
