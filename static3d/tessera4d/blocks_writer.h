// Gaussians as the blocks of a Tessera 4D file: grouped by the time in which they are drawn,
// counted, and handed on block by block, so that no more than one group is held in its encoded
// form.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "recon4d/model/gaussian_set.h"
#include "static3d/tessera4d/block.h"
#include "static3d/tessera4d/manifest.h"
#include "static3d/tessera4d/tessera4d.h"
#include "static3d/transform/scene_box.h"

namespace tessera {

/// Takes a finished block: the name of its file, its bytes.
using BlockSink = std::function<void(const std::string& name, std::string bytes)>;

class BlocksWriter {
 public:
  /// `rules`: how Gaussians are drawn, and the clock of the clip; its sets are not read. `box`: by
  /// which outliers are counted. `windows`: of a file of windows. Errors: InputError: a segment of
  /// no length.
  BlocksWriter(const GaussianModel& rules, const Tessera4dOptions& options, const SceneBox& box,
               BlockSink sink, std::vector<FileWindow> windows = {});

  void add_static(const GaussianSet& set, const MotionNodes& nodes);
  /// The dynamic set of a model, in the time of the clip or of `window`. What is not drawn within
  /// the clip, or the window's core, is left out and counted.
  void add_dynamic(const GaussianModel& model, int window = -1);

  /// Of what has been added.
  const Tessera4dManifest& manifest() const { return manifest_; }
  Tessera4dCounts counts() const;

 private:
  void add_block(const GaussianSet& set, const std::string& name, const BlockInfo& place,
                 const MotionNodes& nodes = MotionNodes());
  void add_blocks(const GaussianSet& set, const std::string& name, const BlockInfo& place);
  void note(const Vec3<float>& mean);

  double segment_seconds_;
  TimeAxis clip_;
  SceneBox box_;
  BlockRules rules_;
  BlockSink sink_;
  Tessera4dManifest manifest_;
};

}  // namespace tessera
