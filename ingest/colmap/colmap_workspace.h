// Files and commands that all runs of COLMAP share: images, masks, the database, models with known
// poses, and the choice among the resulting models.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "ingest/colmap/colmap_program.h"
#include "ingest/colmap/rig_background.h"
#include "ingest/files/fnv1a.h"
#include "ingest/poses/lens.h"

namespace tessera {

/// Options of ColmapWorkspace::find_matches.
struct FeatureOptions {
  std::string lens_model = "SIMPLE_RADIAL";
  bool intrinsics_per_camera = false;  // false: images of one size share them
};

class ColmapWorkspace {
 public:
  explicit ColmapWorkspace(const std::filesystem::path& folder);

  std::filesystem::path folder, images, masks, database, sparse;

  /// Removes what earlier runs left here, but not the log.
  void clear() const;
  /// The name that image number `index` has for COLMAP: "480x360/007.png", free of blanks.
  static std::string image_name(size_t index, const Image8& image);
  /// Writes image and mask; returns the name.
  std::string add(size_t index, const StillImage& still) const;
  /// Features of all images, matched with each other.
  void find_matches(const ColmapProgram& colmap, const FeatureOptions& options, size_t count) const;
  /// Points from the images of `model` alone, with poses and lenses as stated there, into the
  /// folder `out`. `max_error`: of a feature, pixels.
  void triangulate(const ColmapProgram& colmap, const std::filesystem::path& model,
                   const std::filesystem::path& out, double max_error) const;
  /// Whether `key` is the one that `store_key` stored here.
  bool holds(const std::string& key) const;
  void store_key(const std::string& key) const;
};

/// Reprojection error at which a feature is off, pixels: what features of sharp images reach, in
/// proportion where images are larger, for lenses fit a share of the size.
double tight_error(int width);

/// The folder below `sparse` whose model has the most registered images; says so in `warnings`
/// where there are several and that one has not all `images`. An empty path where there is none.
std::filesystem::path largest_colmap_model(const std::filesystem::path& sparse, size_t images,
                                           std::vector<std::string>& warnings);

struct PosedImage {
  std::string name;  // below the folder of the images
  RigCamera camera;
};

/// A camera as cameras.txt has it: "PINHOLE 480 360 400 400 240 180". Errors: InputError: a model's
/// name that COLMAP does not have.
std::string colmap_lens_line(const RigCamera& camera);

/// Images of equal lenses share one camera, so that what refines them keeps them equal. Errors:
/// InputError: the folder cannot be written, an unknown model's name.
void write_posed_model(const std::filesystem::path& folder, const std::vector<PosedImage>& images);

}  // namespace tessera
