// Short films of made-up worlds by ray casting, trainings of presets on them that take seconds, and
// measurements in the resulting images. The images are exact up to 8-bit rounding and are not
// rendered from splats.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "recon4d/evaluation/render.h"
#include "tests/support/tiny_capture.h"
#include "tools/synth/world.h"

namespace tessera::testing {

/// Cameras on an arc in front (−y) of the origin, z up, two rows; another one, camera "middle", is
/// held out (Split::kTest). What is behind the solids is black and known to be empty.
struct Film {
  int cameras = 6, timesteps = 16, width = 64, height = 64;
  double arc = 1.0;                           // that the cameras share, radians
  double distance = 4;                        // to the origin, world units
  double field = 0.6;                         // horizontal field of view, radians
  bool alpha = true;                          // what is empty is known: initial points fill a box
  std::function<synth::World(double)> world;  // what there is at time [0, 1]

  /// Pixels that a world unit across the view covers at the origin.
  double pixels_a_unit() const;
  double time(int timestep) const { return timesteps < 2 ? 0 : double(timestep) / (timesteps - 1); }
};

/// Frames ordered by timestep, the held-out camera's last of each.
Scene shoot(const Film& film);
/// `still` points of what never changes and `moving` ones of what does, with their timesteps: where
/// rays of training cameras meet the world. As a sweep would find them in images of more pixels.
PointCloud surface_cloud(const Film& film, int still, int moving);
/// Those of the held-out camera, by timestep.
std::vector<const Frame*> held_out(const Scene& scene);
/// One light all around, so that colours are those of the textures × 0.85 where normals are level.
synth::World even_world();
/// Added to `world`: a solid at `place` that differs at each timestep.
synth::Solid& add_solid(synth::World& world, synth::ShapeKind kind, glm::dvec3 half,
                        glm::dvec3 place, const synth::Texture& texture, bool moves = true);
/// Textures of three colours, warm and cold; `gain` dims them.
synth::Texture warm(double cell, double gain = 1);
synth::Texture cold(double cell);

/// A preset in `steps` steps for images of a few thousand pixels. Rates of what has to travel
/// (means, velocities) are raised so that a Gaussian comes as far as in the preset's own steps; few
/// pixels make strong gradients, so the threshold of density control is raised too.
TrainOptions short_training(const std::string& preset, int64_t steps);
/// Trained to the end, from the scene's own cloud where there is one.
GaussianModel trained(const Scene& scene, const TrainOptions& options);
/// With the preset's decisions on what moves, how many are needed and their colours; the limit of
/// `options` is that of growth.
GaussianModel decided(const Scene& scene, TrainOptions options);

/// The model seen by the held-out camera at each of its timesteps.
std::vector<RenderedImage> middle_images(const GaussianModel& model, const Scene& scene);
/// Mean over the views, un-quantised, dB.
double middle_psnr(const GaussianModel& model, const Scene& scene);
/// Standard deviation over the images of each value (planar, as Image::rgb), 8-bit steps.
std::vector<double> deviation_over_time(const std::vector<RenderedImage>& images);
/// Pixel coordinates of the mean of all brightness; {−1, −1} where there is none.
std::array<double, 2> centroid(const RenderedImage& image);
RenderedImage image_of(const Image8& image);
/// Largest difference of a value, in 8-bit steps.
double largest_difference(const RenderedImage& a, const RenderedImage& b);

}  // namespace tessera::testing
