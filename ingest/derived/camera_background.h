// What one fixed camera sees behind all that moves, told from images spread over a clip.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

namespace tessera {

constexpr int64_t kMostOfQuarter = 31;  // images; four quarters are counted in bytes

/// The background of a camera and where it is known: a pixel has one colour in all quarters of the
/// clip, in at least 0.4 of the images, and in 0.2 of them more than any other. A colour is that of
/// the images that differ by less than noise, all in the light of the first quarter.
class CameraBackground {
 public:
  using Images = std::vector<const std::vector<uint8_t>*>;  // RGB, 8 bits, of one size

  /// The images of the next of the clip's quarters, one to kMostOfQuarter.
  void add_quarter(const Images& images);
  /// RGB; to be used after all quarters.
  std::vector<uint8_t> image() const;
  /// Whether a pixel shows its background all along. What moves on one spot or blinks has no
  /// colour that leads, and what was moved has another one in some quarter.
  bool stays(size_t pixel) const;

 private:
  void add_in_one_light(const Images& images);

  std::vector<std::vector<uint8_t>> quarters_;  // RGB of each
  std::vector<uint8_t> light_;                  // an image in the light of the first quarter
  std::vector<uint8_t> at_rest_;                // images that show it, by pixel
  std::vector<uint8_t> beside_;                 // images with the colour that is second
  int64_t count_ = 0;                           // images
  int most_change_ = 0;                         // of a still pixel between quarters, 8-bit units
};

}  // namespace tessera
