// Motion nodes and the bindings of canonical Gaussians as streams of a block.
// Source: docs/reference/tessera4d.md, section 4.1.
#pragma once
#include <filesystem>
#include <string_view>
#include <vector>

#include "recon4d/model/gaussian_set.h"
#include "static3d/tessera4d/stream.h"

namespace tessera {

/// Whether Gaussian n of a canonical set has a node.
bool is_bound(const GaussianSpans<const float>& set, int64_t n);

/// Rows of a stream of a canonical block that is not one of Gaussians: nodes, or their control
/// points; 0: it has a row for each Gaussian.
int64_t node_rows(std::string_view name, int64_t nodes, int knots);

/// Of a canonical set in the order of the block, every Gaussian of which has a node. `step`: of
/// positions, world units; not read where `lossless`.
std::vector<StreamWords> node_streams(const GaussianSet& set, const MotionNodes& nodes, double step,
                                      bool lossless);

/// Bindings of the Gaussians of a block with `nodes` nodes, from its streams `node` and either
/// `node_weight` or `node_logit`. Errors: InputError naming `path`: a node that is not there.
void read_bindings(const StreamWords& node, const StreamWords& weight, int64_t nodes,
                   const GaussianSpans<float>& to, const std::filesystem::path& path);

/// The streams of nodes alone; `log_radius`: of a lossless file, else null.
struct NodeStreams {
  StreamWords position, translation, rotation;
  const StreamWords* log_radius = nullptr;
};
/// Errors: InputError naming `path`: values that are not finite.
MotionNodes nodes_from(const NodeStreams& streams, int64_t count, int knots,
                       const std::filesystem::path& path);

}  // namespace tessera
