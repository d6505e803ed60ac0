// Draws each chosen view once; errors are coloured, and images compressed, on all threads.
#include "tools/report/run_images.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <map>
#include <numeric>
#include <utility>

#include "ingest/files/atomic_file.h"
#include "ingest/files/png.h"
#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"
#include "recon4d/training/scene_scale.h"
#include "tools/video/video_encoder.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

constexpr int kStripWidth = 320, kFullWidth = 1600, kSmallestFullWidth = 480;  // pixels, at most
constexpr size_t kStripFrames = 12, kAllStripFrames = 96;
constexpr size_t kFullBytes = 2'000'000, kStripBytes = 1'300'000;
constexpr int kQuantiser = 4;  // of JPEG

struct Triple {
  Image8 truth, result, error;
};

class ImageMaker {
 public:
  ImageMaker(const ViewSource& source, const std::vector<ScoredView>& views,
             const fs::path& scratch)
      : source_(source), views_(views), scratch_(scratch) {}

  /// Those that are not drawn yet, ascending in time: of a clip in windows one after the other.
  void draw(std::vector<size_t> wanted) {
    std::stable_sort(wanted.begin(), wanted.end(),
                     [&](size_t a, size_t b) { return views_[a].time < views_[b].time; });
    std::vector<std::pair<Triple*, Image8>> drawn;  // without its error, and its mask
    for (const size_t view : wanted) {
      if (triples_.contains(view)) continue;
      std::optional<RenderedView> images = source_(views_[view]);
      if (!images) continue;
      Triple& triple = triples_[view];
      triple = {std::move(images->truth), std::move(images->result), {}};
      drawn.emplace_back(&triple, std::move(images->mask));
    }
    parallel_for(int64_t(drawn.size()), 1, [&](int64_t first, int64_t last) {
      for (auto i = size_t(first); i < size_t(last); ++i) {
        auto& [triple, mask] = drawn[i];
        triple->error = error_map(triple->result, triple->truth, mask);
      }
    });
  }

  bool has(size_t view) const { return triples_.contains(view); }

  /// Of views that are drawn.
  std::vector<ShownView> shown(const std::vector<size_t>& views, int width) const {
    std::vector<ShownView> shown(views.size());
    parallel_for(int64_t(views.size()), 1, [&](int64_t first, int64_t last) {
      for (auto i = size_t(first); i < size_t(last); ++i) {
        const Triple& images = triples_.at(views[i]);
        shown[i].view = views[i];
        shown[i].truth = encoded(images.truth, width, shown[i]);
        shown[i].result = encoded(images.result, width, shown[i]);
        shown[i].error = encoded(images.error, width, shown[i]);
      }
    });
    return shown;
  }

 private:
  EncodedImage encoded(const Image8& image, int width, ShownView& shown) const {
    Image8 small = narrowed_image(image, width);
    shown.width = small.width;
    shown.height = small.height;
    if (auto bytes = jpeg_bytes(small, kQuantiser)) return {"image/jpeg", std::move(*bytes)};
    small = narrowed_image(small, kStripWidth);
    const fs::path file = scratch_ / fmt::format(".view-{}.png", shown.view);
    write_png(file, small);
    EncodedImage png{"image/png", read_text_file(file)};
    fs::remove(file);
    return png;
  }

  const ViewSource& source_;
  const std::vector<ScoredView>& views_;
  const fs::path scratch_;
  std::map<size_t, Triple> triples_;
};

size_t bytes_of(const std::vector<ShownView>& views) {
  size_t bytes = 0;
  for (const ShownView& view : views)
    bytes += view.truth.bytes.size() + view.result.bytes.size() + view.error.bytes.size();
  return bytes;
}

std::vector<ShownView> telling(const ImageMaker& maker, const std::vector<ChosenView>& all,
                               int width) {
  std::vector<size_t> drawn;
  std::vector<std::string> roles;
  for (const ChosenView& chosen : all) {
    if (!maker.has(chosen.view)) continue;
    drawn.push_back(chosen.view);
    roles.push_back(chosen.role);
  }
  std::vector<ShownView> views = maker.shown(drawn, width);
  for (size_t i = 0; i < views.size(); ++i) views[i].role = roles[i];
  return views;
}

std::vector<size_t> views_in(const std::vector<CameraViews>& strips) {
  std::vector<size_t> views;
  for (const CameraViews& camera : strips)
    views.insert(views.end(), camera.views.begin(), camera.views.end());
  return views;
}

/// Views of `strips` that are not in `telling`, which learns which of its own are.
std::vector<ShownView> over_time(const ImageMaker& maker, const std::vector<CameraViews>& strips,
                                 std::vector<ShownView>& telling) {
  std::vector<size_t> others;
  for (const size_t view : views_in(strips)) {
    const auto known = std::find_if(telling.begin(), telling.end(),
                                    [&](const ShownView& shown) { return shown.view == view; });
    if (known != telling.end())
      known->in_strip = true;
    else if (maker.has(view))
      others.push_back(view);
  }
  std::vector<ShownView> made = maker.shown(others, kStripWidth);
  for (ShownView& view : made) view.in_strip = true;
  return made;
}

using Colour = std::array<uint8_t, 3>;

// at equal distances
constexpr std::array<Colour, 5> kScale = {
    {{8, 8, 16}, {74, 24, 110}, {186, 54, 84}, {248, 140, 40}, {252, 248, 176}}};
constexpr Colour kIgnored = {128, 128, 128};

Colour colour_of(double error) {
  const double place = std::clamp(error / kLargestShownError, 0.0, 1.0) * double(kScale.size() - 1);
  const size_t i = std::min(size_t(place), kScale.size() - 2);
  const double share = place - double(i);
  Colour colour{};
  for (size_t c = 0; c < 3; ++c)
    colour[c] = uint8_t(std::lround((1 - share) * kScale[i][c] + share * kScale[i + 1][c]));
  return colour;
}

}  // namespace

std::vector<ShownView> run_images(const ViewSource& source, const std::vector<ScoredView>& views,
                                  const fs::path& scratch) {
  ImageMaker maker(source, views, scratch);
  const std::vector<ChosenView> chosen = telling_views(views);
  const size_t cameras = std::max<size_t>(1, strip_views(views, 2).size());
  size_t most = std::clamp<size_t>(kAllStripFrames / cameras, 2, kStripFrames);
  std::vector<CameraViews> strips = strip_views(views, most);
  std::vector<size_t> wanted = views_in(strips);
  for (const ChosenView& view : chosen) wanted.push_back(view.view);
  maker.draw(std::move(wanted));
  int width = kFullWidth;
  std::vector<ShownView> shown = telling(maker, chosen, width), small;
  for (; bytes_of(shown) > kFullBytes && width > kSmallestFullWidth;
       shown = telling(maker, chosen, width))
    width = int(0.75 * std::min(width, shown.front().width));
  while (true) {
    for (ShownView& view : shown) view.in_strip = false;
    maker.draw(views_in(strips));
    small = over_time(maker, strips, shown);
    if (bytes_of(small) <= kStripBytes || strips.empty()) break;
    if (most > 2)
      strips = strip_views(views, most = std::max<size_t>(2, most * 2 / 3));
    else
      strips.pop_back();
  }
  std::move(small.begin(), small.end(), std::back_inserter(shown));
  return shown;
}

std::vector<CameraViews> strip_views(const std::vector<ScoredView>& views, size_t most) {
  std::vector<CameraViews> cameras;
  for (size_t i = 0; i < views.size(); ++i) {
    const auto same = [&](const CameraViews& known) { return known.camera == views[i].camera; };
    auto found = std::find_if(cameras.begin(), cameras.end(), same);
    if (found == cameras.end()) found = cameras.insert(cameras.end(), {views[i].camera, {}});
    found->views.push_back(i);
  }
  for (CameraViews& camera : cameras) {
    const size_t count = camera.views.size();
    if (count <= most) continue;
    std::vector<size_t> kept;
    for (size_t k = 0; k < most; ++k)
      kept.push_back(camera.views[(k * (count - 1) + (most - 1) / 2) / (most - 1)]);
    camera.views = std::move(kept);
  }
  return cameras;
}

std::vector<ChosenView> telling_views(const std::vector<ScoredView>& views) {
  std::vector<size_t> order(views.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return views[a].psnr < views[b].psnr; });
  if (order.empty()) return {};
  std::vector<ChosenView> chosen = {{"worst", order.front()}};
  if (order.size() > 2) chosen.push_back({"median", order[order.size() / 2]});
  if (order.size() > 1) chosen.push_back({"best", order.back()});
  return chosen;
}

Image8 error_map(const Image8& drawn, const Image8& truth, const Image8& mask) {
  check(drawn.width == truth.width && drawn.height == truth.height && drawn.channels == 3 &&
            truth.channels == 3,
        "an error map needs two RGB images of one size");
  Image8 map{truth.width, truth.height, 3, {}};
  map.data.resize(truth.data.size());
  for (size_t pixel = 0; 3 * pixel < map.data.size(); ++pixel) {
    int sum = 0;
    for (size_t c = 3 * pixel; c < 3 * pixel + 3; ++c)
      sum += std::abs(int(drawn.data[c]) - int(truth.data[c]));
    const bool used = mask.data.empty() || mask.data[pixel] != 0;
    const Colour colour = used ? colour_of(sum / 3.0) : kIgnored;
    std::copy(colour.begin(), colour.end(), map.data.begin() + std::ptrdiff_t(3 * pixel));
  }
  return map;
}

}  // namespace tessera
