// The similarity that gives a capture a world with up = +z, its centre at the origin and its
// cameras at distance 4. Source: method E.3 (centre of optical axes, mean up, distance 4), with
// robust means.
#pragma once
#include <string>
#include <vector>

#include "ingest/scene.h"
#include "kernels/base/similarity.h"

namespace tessera {

/// Where the cameras stand about the centre afterwards, in world units: learning rates, near plane
/// 0.2 and far plane 100 of the published 4D protocols are made for it.
inline constexpr double kNormalisedDistance = 4;

/// prepared_from_source by the training cameras (one entry a pose) and the initial cloud, which may
/// be empty. `cameras` must not be empty.
///
/// Up: the direction across the cameras' right axes (people and tripods hold the horizon level)
/// where these vary enough to determine it (an orbit); else the geometric median of the cameras'
/// own up axes (a rig that looks one way). It is turned to +z by the shortest rotation. Centre: the
/// point nearest to the viewing axes, outlying cameras weighted down, where the axes meet in front
/// of most cameras; else the cameras' mean, moved along their mean direction by the median depth of
/// the points. Scale: median distance of the cameras to the centre → 4 (median depth of the points,
/// if larger, where the axes do not meet), and more where the nearest points would lie before the
/// near plane. Without any length to measure (one camera, no points) the scale stays.
Similarity normalised_from_source(const std::vector<Camera>& cameras, const PointCloud& points);

/// The change of a world that protocols and other programs rely on: none where the training cameras
/// stand 0.4 to 40 units from what they see; else it is scaled to kNormalisedDistance and centred,
/// never turned, so that results do not depend on the unit. What cameras see lies where their axes
/// meet, else at the median depth of the points, else ten times as far as the cameras stand apart.
/// Intrinsics are not looked at; without any length nothing is changed.
Similarity usable_from_stated(const std::vector<Camera>& cameras, const PointCloud& points);

/// A line about a stated world that was moved, from which `prepared_from_source` leads back; empty
/// where it was not.
std::string stated_world_text(const Similarity& prepared_from_source);

}  // namespace tessera
