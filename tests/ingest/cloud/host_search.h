// A search of pixels as a device does it, on the host: in what is copied from the views that it is
// given, all pixels of a call at once.
#pragma once
#include <map>
#include <memory>

#include "ingest/cloud/ray_search.h"
#include "kernels/pixel_search.h"

namespace tessera::testing {

class HostSearch : public PixelSearch {
 public:
  void set_views(const std::vector<SearchView>& views, const DepthRange& range) override {
    ++sets;
    range_ = range;
    views_ = views;
    images_.clear();
    for (SearchView& view : views_) {
      if (view.image.data == nullptr) continue;
      const size_t pixels = size_t(view.image.width) * size_t(view.image.height);
      images_.emplace_back(view.image.data, view.image.data + 3 * pixels);
      view.image.data = images_.back().data();
      std::vector<uint8_t> grey(pixels);
      for (size_t i = 0; i < pixels; ++i) grey[i] = grey_level(view.image.data + 3 * i);
      images_.push_back(std::move(grey));
      view.grey = images_.back().data();
    }
  }
  std::vector<RayDepth> depths(const std::vector<RayQuery>& queries) override {
    std::vector<RayDepth> found;
    for (const RayQuery& query : queries) found.push_back(ray_depth(views_, range_, query));
    searched += int64_t(queries.size());
    return found;
  }
  std::vector<uint8_t> moves(const std::vector<ViewPixel>& pixels) override {
    std::vector<uint8_t> found;
    for (const auto& [view, x, y] : pixels) found.push_back(views_[size_t(view)].moves(x, y));
    return found;
  }

  int64_t sets = 0, searched = 0;

 private:
  DepthRange range_{};
  std::vector<SearchView> views_;
  std::vector<std::vector<uint8_t>> images_;
};

}  // namespace tessera::testing
