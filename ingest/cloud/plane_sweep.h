// The depth of a pixel at which the other cameras of its timestep agree with it. Monocular captures
// have no depth here, because no two cameras share a timestep. Source: plane sweep [Collins96]; the
// check from another camera is the left-right check of stereo matching.
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <optional>

#include "ingest/cloud/expected_motion.h"
#include "ingest/cloud/grey_patch.h"
#include "ingest/cloud/still_pixels.h"
#include "ingest/scene.h"
#include "kernels/pixel_search.h"

namespace tessera {

/// A point with its values from the images.
struct SweptPoint {
  glm::vec3 position;             // world units
  std::array<uint8_t, 3> colour;  // of the image it was found in
  float time;                     // normalised timestep of that image
  bool still;                     // that pixel looks the same at other timesteps of the clip
  float pixel;                    // size of a pixel there, world units
  int frame;                      // that image, index into Scene::frames
  /// World units per unit of normalised time: that with which the cameras agreed on the point, then
  /// that of point_velocities.h.
  glm::vec3 velocity{0};
};

/// Where the point is `later` than its frame, in units of normalised time.
inline glm::dvec3 place_at(const SweptPoint& point, double later) {
  return glm::dvec3(point.position) + later * glm::dvec3(point.velocity);
}

/// Gives a view all of a frame but a grey image. Image and mask are not copied.
void set_frame(const Frame& frame, const StillPixels& still_pixels, SearchView& view);

/// Takes a byte for each pixel of `scene`. Depths between a quarter of and four times the cameras'
/// distance to what they look at.
class PlaneSweep {
 public:
  /// Looks at the training frames only, of which there is one at least. `scene` must outlive this.
  explicit PlaneSweep(const Scene& scene);
  /// Moving pixels are found by other frames of the same cameras. Pixels are searched by `device`,
  /// which must outlive this and be used by no other sweep meanwhile; null: on the CPU.
  PlaneSweep(const Scene& scene, std::shared_ptr<const StillPixels> still_pixels,
             PixelSearch* device = nullptr);
  const Scene& scene() const { return scene_; }
  /// From here on a pixel is also compared with the other cameras as something that moves as the
  /// points near it do, which is seen elsewhere by a camera with another time. `points`: of the one
  /// timestep of the sweep. False, and nothing changes, where none of them moves by more than
  /// kLeastShift pixels between the cameras' times.
  bool expect_motion_of(const std::vector<SweptPoint>& points);
  static constexpr double kLeastShift = 0.25;
  /// Frames with at least two others of their timestep, indices into Scene::frames.
  const std::vector<int>& frames() const { return usable_; }
  /// The points of pixels of frames(), in their order. None where a mask ignores the pixel, or
  /// without texture, agreement, a distinct best depth, or confirmation from the other camera.
  std::vector<SweptPoint> find(const std::vector<ViewPixel>& pixels) const;
  /// Of each of `groups` groups of `each` pixels, the first that moves or, if not `moving`, does
  /// not; of some groups there is none. `pixel`: by its number, groups follow one another.
  std::vector<ViewPixel> first_of(int64_t groups, int64_t each, bool moving,
                                  const std::function<ViewPixel(int64_t)>& pixel) const;
  /// Whether the pixel of one of frames() looks different at another time of the clip; false at the
  /// image's edge, where no patch fits.
  bool moves(const ViewPixel& pixel) const;
  /// The frame that the point was found in, and those that it was compared with and which agree on
  /// what the point looks like.
  std::vector<int> agreeing_frames(const SweptPoint& point) const;

 private:
  struct Depth;  // what a search along a ray found

  std::vector<RayDepth> depths(const std::vector<RayQuery>& queries) const;
  std::vector<std::optional<Depth>> search(const std::vector<ViewPixel>& pixels) const;
  glm::dvec2 pixel_of(const glm::dvec3& point, int frame) const;
  bool still(const ViewPixel& pixel) const;
  void choose_neighbours(const std::vector<int>& frames);

  const Scene& scene_;
  DepthRange range_;
  std::vector<int> usable_;
  std::vector<SearchView> views_;  // [frames of the scene], those of usable_ complete
  std::map<int, GreyImage> grey_;  // of usable_
  PixelSearch* device_;
  std::optional<ExpectedMotion> expected_;
};

}  // namespace tessera
