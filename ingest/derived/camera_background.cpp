// Where most images are as their median, that is the background. Elsewhere it is the colour that
// most images have, and only there all pairs of images are compared.
#include "ingest/derived/camera_background.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>

#include "kernels/base/byte_medians.h"
#include "kernels/base/errors.h"
#include "kernels/base/light_gain.h"
#include "kernels/base/parallel.h"

namespace tessera {
namespace {

constexpr int kMostChange = 10;  // 8-bit units, between quarters
// Shares of the images. A majority of kMajority leads by kLeastLead whatever the others show.
constexpr double kMajority = 0.6, kLeastAtRest = 0.4, kLeastLead = 0.2, kLeastUsed = 0.25;

using Colour = std::array<uint8_t, 3>;

bool is_near(const uint8_t* a, const uint8_t* b, int most) {
  return std::abs(int(a[0]) - int(b[0])) <= most && std::abs(int(a[1]) - int(b[1])) <= most &&
         std::abs(int(a[2]) - int(b[2])) <= most;
}

/// The colours of one pixel in the images of a quarter that use it.
class PixelColours {
 public:
  PixelColours(const CameraBackground::Images& images, const CameraBackground::Images& masks,
               size_t pixel, int most)
      : most_(most) {
    for (size_t i = 0; i < images.size(); ++i)
      if (masks[i]->empty() || (*masks[i])[pixel] != 0)
        std::copy_n(images[i]->data() + 3 * pixel, 3, colours_[count_++].begin());
  }
  int count() const { return int(count_); }
  int near(const uint8_t* colour) const {
    int found = 0;
    for (size_t i = 0; i < count_; ++i) found += is_near(colours_[i].data(), colour, most_) ? 1 : 0;
    return found;
  }
  /// The mean of the images around that image which most others are near to.
  Colour most_frequent() const {
    size_t centre = 0;
    int most_near = 0;
    for (size_t i = 0; i < count_; ++i) {
      const int found = near(colours_[i].data());
      if (found > most_near) centre = i;
      most_near = std::max(most_near, found);
    }
    std::array<int, 3> sum{};
    int among = 0;
    for (size_t i = 0; i < count_; ++i) {
      if (!is_near(colours_[i].data(), colours_[centre].data(), most_)) continue;
      for (size_t c = 0; c < 3; ++c) sum[c] += colours_[i][c];
      ++among;
    }
    Colour mean;
    for (size_t c = 0; c < 3; ++c) mean[c] = uint8_t((2 * sum[c] + among) / (2 * among));
    return mean;
  }
  void drop_near(const Colour& colour) {
    const auto end = std::remove_if(
        colours_.begin(), colours_.begin() + std::ptrdiff_t(count_),
        [&](const Colour& other) { return is_near(other.data(), colour.data(), most_); });
    count_ = size_t(end - colours_.begin());
  }
  bool empty() const { return count_ == 0; }

 private:
  std::array<Colour, kMostOfQuarter> colours_;
  size_t count_ = 0;
  int most_;
};

}  // namespace

void CameraBackground::add_quarter(const Images& images, const Images& masks) {
  check(
      !images.empty() && int64_t(images.size()) <= kMostOfQuarter && images.size() == masks.size(),
      "CameraBackground: 1 to 31 images of a quarter, with their masks");
  if (light_.empty()) light_ = lower_medians(images);
  Images in_one_light;
  std::vector<std::vector<uint8_t>> changed;
  changed.reserve(images.size());
  for (const std::vector<uint8_t>* image : images) {
    const LightGain gain = light_gain(*image, light_);
    if (gain != kSameLight) changed.push_back(times_light(*image, inverse(gain)));
    in_one_light.push_back(gain == kSameLight ? image : &changed.back());
  }
  add_in_one_light(in_one_light, masks);
}

void CameraBackground::add_in_one_light(const Images& images, const Images& masks) {
  std::vector<uint8_t> background = lower_medians(images);
  const int most = still_limit(images, background);
  const auto count = int(images.size());
  at_rest_.resize(background.size() / 3);
  for (std::vector<uint8_t>* counts : {&beside_, &used_, &seen_}) counts->resize(at_rest_.size());
  // of noise, the median of n images has 1.25 / √n; medians differ by five times that at most
  most_change_ =
      std::max({most_change_, kMostChange, int(std::lround(2 * most / std::sqrt(count)))});
  parallel_for(int64_t(at_rest_.size()), 1 << 12, [&](int64_t begin, int64_t end) {
    for (auto p = size_t(begin); p < size_t(end); ++p) {
      PixelColours colours(images, masks, p, most);
      const int used = colours.count();
      if (used == 0) continue;
      int at_rest = colours.near(&background[3 * p]), beside = used - at_rest;
      if (used < count || at_rest < kMajority * used) {
        const Colour colour = colours.most_frequent();
        std::copy(colour.begin(), colour.end(), background.begin() + std::ptrdiff_t(3 * p));
        at_rest = colours.near(colour.data());
        colours.drop_near(colour);
        beside = colours.empty() ? 0 : colours.near(colours.most_frequent().data());
      }
      at_rest_[p] = uint8_t(at_rest_[p] + at_rest);
      beside_[p] = uint8_t(beside_[p] + beside);
      used_[p] = uint8_t(used_[p] + used);
      seen_[p] = uint8_t(seen_[p] | 1 << quarters_.size());
    }
  });
  count_ += count;
  quarters_.push_back(std::move(background));
}

std::vector<uint8_t> CameraBackground::image() const {
  Images all;
  for (const std::vector<uint8_t>& quarter : quarters_) all.push_back(&quarter);
  std::vector<uint8_t> image = lower_medians(all);
  const int every = (1 << quarters_.size()) - 1;
  for (size_t p = 0; p < seen_.size(); ++p) {
    if (seen_[p] == 0 || seen_[p] == every) continue;
    const std::vector<uint8_t>& quarter = quarters_[size_t(std::countr_zero(seen_[p]))];
    std::copy_n(quarter.begin() + std::ptrdiff_t(3 * p), 3, image.begin() + std::ptrdiff_t(3 * p));
  }
  return image;
}

bool CameraBackground::stays(size_t pixel) const {
  const double at_rest = at_rest_[pixel], lead = at_rest - beside_[pixel], used = used_[pixel];
  if (used < kLeastUsed * double(count_)) return false;
  if (at_rest < kLeastAtRest * used || lead < kLeastLead * used) return false;
  for (size_t a = 0; a < quarters_.size(); ++a)
    for (size_t b = 0; b < a; ++b) {
      const bool both = (seen_[pixel] >> a & 1) != 0 && (seen_[pixel] >> b & 1) != 0;
      if (both && !is_near(&quarters_[a][3 * pixel], &quarters_[b][3 * pixel], most_change_))
        return false;
    }
  return true;
}

}  // namespace tessera
