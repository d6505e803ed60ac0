// A warp a query: lanes on the planes, then on the fine steps of all sights. A thread a pixel for
// what moves. Sums have the order of the host's loops, so that both find the same.
#include "kernels/pixel_search.h"

#include <map>

#include "kernels/cuda/cuda_backend.h"
#include "kernels/cuda/launch.cuh"

namespace tessera {
namespace {

constexpr int kThreads = 128, kLanes = 32, kWarps = kThreads / kLanes;
constexpr unsigned kAll = 0xffffffffu;

/// What the lanes of a query share.
struct QueryRoom {
  Patch patch;
  int grey[Patch::kPixels];  // levels less their mean, times kPixels
  int grey_sum;              // of the levels
  RaySight sights[kMostSights];
  float mean[kMostPlanes];  // costs of planes, then of fine steps
  float fine[(2 * kFineSteps + 1) * kMostSights];
};

__device__ void write_patches(const SearchView& view, int x, int y, int lane, QueryRoom& room) {
  const int left = x - Patch::kRadius, top = y - Patch::kRadius;
  for (int i = lane; i < Patch::kLevels; i += kLanes) {
    const int row = i / (3 * Patch::kSide);
    room.patch.level[i] = float(view.image.at(left, top + row)[i - row * 3 * Patch::kSide]);
  }
  int level = 0;
  if (lane < Patch::kPixels)
    level = view.grey[int64_t(top + lane / Patch::kSide) * view.image.width + left +
                      lane % Patch::kSide];
  int sum = level;
  for (int offset = kLanes / 2; offset > 0; offset /= 2) sum += __shfl_xor_sync(kAll, sum, offset);
  if (lane < Patch::kPixels) room.grey[lane] = Patch::kPixels * level - sum;
  if (lane == 0) room.grey_sum = sum;
  __syncwarp();
  if (lane < 3) {
    float mean = 0;
    for (int i = lane; i < Patch::kLevels; i += 3) mean += room.patch.level[i];
    room.patch.mean[lane] = mean / float(Patch::kPixels);
  }
  __syncwarp();
  for (int i = lane; i < Patch::kLevels; i += kLanes) room.patch.level[i] -= room.patch.mean[i % 3];
  __syncwarp();
}

/// In grey and at the whole pixel that the sight has at an inverse depth.
__device__ float plane_cost(const QueryRoom& room, const RaySight& sight, double w) {
  double u, v;
  if (!sight.at(w, u, v)) return kNotCompared;
  const SearchView& view = *sight.view;
  const uint8_t* from =
      view.grey + int64_t(int(v) - Patch::kRadius) * view.image.width + int(u) - Patch::kRadius;
  int level[Patch::kPixels], sum = 0;
  TESSERA_UNROLL for (int i = 0; i < Patch::kPixels; ++i) {
    level[i] = from[int64_t(i / Patch::kSide) * view.image.width + i % Patch::kSide];
    sum += level[i];
  }
  if (abs(room.grey_sum - sum) > int(kMostGain) * Patch::kPixels) return kNotCompared;
  int apart = 0;
  TESSERA_UNROLL for (int i = 0; i < Patch::kPixels; ++i) apart +=
      abs(Patch::kPixels * level[i] - sum - room.grey[i]);
  return float(apart) / float(Patch::kPixels * Patch::kPixels);
}

/// The best plane of all lanes, if no other valley is nearly as deep; else −1.
__device__ int best_plane(const RayPlanes& planes, int sights, int lane, QueryRoom& room) {
  float least = kNoAgreement;
  int best = kMostPlanes;
  for (int k = lane; k < planes.count; k += kLanes) {
    float costs[kMostSights];
    for (int i = 0; i < sights; ++i) costs[i] = plane_cost(room, room.sights[i], planes.inverse(k));
    int view;
    room.mean[k] = agreement(costs, room.sights, sights, view);
    if (room.mean[k] < least) {
      least = room.mean[k];
      best = k;
    }
  }
  for (int offset = kLanes / 2; offset > 0; offset /= 2) {
    const float other = __shfl_xor_sync(kAll, least, offset);
    const int plane = __shfl_xor_sync(kAll, best, offset);
    if (other < least || (other == least && plane < best)) {
      least = other;
      best = plane;
    }
  }
  if (best == kMostPlanes) return -1;
  __syncwarp();
  bool rival = false;
  for (int k = lane; k < planes.count; k += kLanes)
    rival = rival || is_rival(k, room.mean[k], best, least);
  return __any_sync(kAll, rival) ? -1 : best;
}

__device__ RayDepth depth_of(const SearchView* views, const DepthRange& range,
                             const RayQuery& query, int lane, QueryRoom& room) {
  const int x = query.pixel.x, y = query.pixel.y;
  const SearchView& view = views[query.pixel.view];
  if (view.other_count == 0 || !has_patch(view.image, x, y) || view.ignores(x, y)) return {};
  write_patches(view, x, y, lane, room);
  const float structure = texture(room.patch);
  if (structure < kLeastTexture) return {};
  const int sights = view.other_count;
  if (lane < sights) {
    const int other = view.others[lane];
    room.sights[lane] = sight_of(view, ray_of(view, x, y), query.velocity, views[other], other);
  }
  __syncwarp();
  const RayPlanes planes = planes_of(view, views[view.others[sights / 2]], range);
  const int plane = best_plane(planes, sights, lane, room);
  if (plane < 0) return {};
  constexpr int kSteps = 2 * kFineSteps + 1;
  for (int i = lane; i < kSteps * sights; i += kLanes) {
    const double place = plane + kFineStep * (i / sights - kFineSteps);
    room.fine[i] = fine_cost(room.patch, room.sights[i % sights], planes.inverse(place));
  }
  __syncwarp();
  int best;
  if (lane < kSteps)
    room.mean[lane] = agreement(room.fine + lane * sights, room.sights, sights, best);
  __syncwarp();
  const double fine = refined_plane(plane, room.mean);
  if (lane < sights)
    room.fine[lane] = fine_cost(room.patch, room.sights[lane], planes.inverse(fine));
  __syncwarp();
  const float cost = agreement(room.fine, room.sights, sights, best);
  const double inverse = planes.inverse(fine);
  if (!(cost < most_cost(structure)) || !(inverse > 0)) return {};
  return {inverse, best, cost};
}

__global__ void __launch_bounds__(kThreads)
    write_depths(const SearchView* views, DepthRange range, const RayQuery* queries, int64_t count,
                 RayDepth* depths) {
  __shared__ QueryRoom rooms[kWarps];
  const int warp = int(threadIdx.x) / kLanes, lane = int(threadIdx.x) % kLanes;
  const int64_t query = int64_t(blockIdx.x) * kWarps + warp;
  if (query >= count) return;
  const RayDepth depth = depth_of(views, range, queries[query], lane, rooms[warp]);
  if (lane == 0) depths[query] = depth;
}

__global__ void __launch_bounds__(kThreads)
    write_moves(const SearchView* views, const ViewPixel* pixels, int64_t count, uint8_t* moves) {
  const int64_t i = linear_index();
  if (i < count) moves[i] = views[pixels[i].view].moves(pixels[i].x, pixels[i].y);
}

__global__ void __launch_bounds__(kThreads)
    write_grey(const uint8_t* rgb, int64_t count, uint8_t* grey) {
  const int64_t i = linear_index();
  if (i < count) grey[i] = grey_level(rgb + 3 * i);
}

int64_t pixels_of(const RgbView& image) {
  return int64_t(image.width) * image.height;
}

class CudaPixelSearch final : public PixelSearch {
 public:
  CudaPixelSearch(Memory& memory, cudaStream_t stream) : memory_(memory), stream_(stream) {}
  void set_views(const std::vector<SearchView>& views, const DepthRange& range) override;
  std::vector<RayDepth> depths(const std::vector<RayQuery>& queries) override;
  std::vector<uint8_t> moves(const std::vector<ViewPixel>& pixels) override;

 private:
  template <class T>
  void copy_in(const std::vector<T>& from, Buffer<T>& to);
  template <class T>
  std::vector<T> copied_out(Buffer<T>& from);
  const uint8_t* kept(const RgbView& image);

  Memory& memory_;
  cudaStream_t stream_;
  DepthRange range_{};
  std::map<const uint8_t*, Buffer<uint8_t>>
      kept_;  // images at other times, by their place on the host
  Buffer<uint8_t> images_{memory_}, grey_{memory_}, masks_{memory_};  // of the views
  Buffer<SearchView> views_{memory_};
  Buffer<RayQuery> queries_{memory_};
  Buffer<RayDepth> depths_{memory_};
  Buffer<ViewPixel> pixels_{memory_};
  Buffer<uint8_t> moves_{memory_};
};

template <class T>
void CudaPixelSearch::copy_in(const std::vector<T>& from, Buffer<T>& to) {
  to.resize(int64_t(from.size()));
  memory_.copy(to.data(), from.data(), sizeof(T) * from.size());
}

template <class T>
std::vector<T> CudaPixelSearch::copied_out(Buffer<T>& from) {
  std::vector<T> to(static_cast<size_t>(from.size()));
  memory_.copy(to.data(), from.data(), sizeof(T) * to.size());
  return to;
}

const uint8_t* CudaPixelSearch::kept(const RgbView& image) {
  const auto [at, is_new] = kept_.try_emplace(image.data, memory_);
  if (is_new) {
    at->second.resize(3 * pixels_of(image));
    memory_.copy(at->second.data(), image.data, size_t(at->second.size()));
  }
  return at->second.data();
}

void CudaPixelSearch::set_views(const std::vector<SearchView>& views, const DepthRange& range) {
  range_ = range;
  std::vector<SearchView> here = views;
  for (SearchView& view : here)
    for (int i = 0; i < view.sight_count; ++i)
      view.sights[i].image.data = kept(view.sights[i].image);
  int64_t pixels = 0, brought = 0, masked = 0;
  std::map<const uint8_t*, int64_t> masks;  // their first pixel; views may share one
  for (const SearchView& view : here) {
    const int64_t count = pixels_of(view.image);
    pixels += count;
    if (!kept_.contains(view.image.data)) brought += count;
    if (view.mask != nullptr && masks.emplace(view.mask, masked).second) masked += count;
  }
  images_.resize(3 * brought);
  grey_.resize(pixels);
  masks_.resize(masked);
  uint8_t *to = images_.data(), *grey = grey_.data();
  for (SearchView& view : here) {
    const int64_t count = pixels_of(view.image);
    if (count == 0) continue;
    if (const auto held = kept_.find(view.image.data); held != kept_.end()) {
      view.image.data = held->second.data();
    } else {
      memory_.copy(to, view.image.data, size_t(3 * count));
      view.image.data = to;
      to += 3 * count;
    }
    launch_linear<kThreads>(stream_, "write_grey", write_grey, count, view.image.data, count, grey);
    view.grey = grey;
    grey += count;
    if (view.mask == nullptr) continue;
    uint8_t* const mask = masks_.data() + masks.at(view.mask);
    memory_.copy(mask, view.mask, size_t(count));
    view.mask = mask;
  }
  copy_in(here, views_);
}

std::vector<RayDepth> CudaPixelSearch::depths(const std::vector<RayQuery>& queries) {
  if (queries.empty()) return {};
  copy_in(queries, queries_);
  depths_.resize(queries_.size());
  write_depths<<<grid_of(queries_.size(), kWarps), kThreads, 0, stream_>>>(
      views_.data(), range_, queries_.data(), queries_.size(), depths_.data());
  check_launch("write_depths");
  return copied_out(depths_);
}

std::vector<uint8_t> CudaPixelSearch::moves(const std::vector<ViewPixel>& pixels) {
  if (pixels.empty()) return {};
  copy_in(pixels, pixels_);
  moves_.resize(pixels_.size());
  launch_linear<kThreads>(stream_, "write_moves", write_moves, pixels_.size(), views_.data(),
                          pixels_.data(), pixels_.size(), moves_.data());
  return copied_out(moves_);
}

}  // namespace

std::unique_ptr<PixelSearch> CudaBackend::pixel_search() {
  return std::make_unique<CudaPixelSearch>(memory_, stream_);
}

}  // namespace tessera
