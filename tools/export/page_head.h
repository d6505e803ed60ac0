// The head of a player page: title, description, tags for sites where its address is posted, the
// poster that is shown during loading, and test images for comparison.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "recon4d/model/gaussian_set.h"
#include "tools/export/formats.h"

namespace tessera {

struct Poster {
  std::string bytes;               // of an image file; empty: no poster
  std::string type = "image/png";  // "image/jpeg" and "image/webp" are the others

  /// "poster.png", "poster.jpg" or "poster.webp"; "" without a poster.
  std::string file() const;
};

struct PageHead {
  std::string title, description;  // plain text; empty: the player's own title, no description
  Poster poster;
  std::string truth;  // JSON array, as of truth_views(); empty: nothing to compare with
};

/// As `request` has them; a poster that is "auto" is rendered. `model`: as exported.
/// Errors: InputError: a poster that cannot be read, no camera to render one from, or no scene with
/// test images where they are asked for.
PageHead page_head(const ExportRequest& request, const GaussianModel& model);

/// The player's page with title, description and poster in their places. `beside`: the poster lies
/// as a file beside the page, too, and the tags for other sites name it.
std::string with_head(std::string page, const PageHead& head, bool beside);

}  // namespace tessera
