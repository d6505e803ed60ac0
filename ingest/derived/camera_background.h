// What one fixed camera sees behind all that moves, told from images spread over a clip.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

namespace tessera {

constexpr int64_t kMostOfQuarter = 31;  // images; four quarters are counted in bytes

/// The background of a camera and where it is known: a pixel has one colour in all quarters of the
/// clip, in at least 0.4 of the images, and in 0.2 of them more than any other. A colour is that of
/// the images that differ by less than noise, all in the light of the first quarter. Images whose
/// mask ignores the pixel do not count; where they are more than three of four, it is not known.
class CameraBackground {
 public:
  using Images = std::vector<const std::vector<uint8_t>*>;  // of 8 bits and one size

  /// The images (RGB) of the next of the clip's quarters, one to kMostOfQuarter, and their masks: 0
  /// ignores the pixel; an empty one uses all.
  void add_quarter(const Images& images, const Images& masks);
  /// RGB; to be used after all quarters.
  std::vector<uint8_t> image() const;
  /// Whether a pixel shows its background all along. What moves on one spot or blinks has no
  /// colour that leads, and what was moved has another one in some quarter.
  bool stays(size_t pixel) const;
  /// Whether some image uses the pixel.
  bool is_used(size_t pixel) const { return used_[pixel] > 0; }

 private:
  void add_in_one_light(const Images& images, const Images& masks);

  std::vector<std::vector<uint8_t>> quarters_;  // RGB of each
  std::vector<uint8_t> light_;                  // an image in the light of the first quarter
  std::vector<uint8_t> at_rest_;                // images that show it, by pixel
  std::vector<uint8_t> beside_;                 // images with the colour that is second
  std::vector<uint8_t> used_;                   // images that use it
  std::vector<uint8_t> seen_;                   // a bit for each quarter of these
  int64_t count_ = 0;                           // images
  int most_change_ = 0;                         // of a still pixel between quarters, 8-bit units
};

}  // namespace tessera
