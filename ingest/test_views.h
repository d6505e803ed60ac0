// The test split of a scene: the cameras or images that the user holds out, and a line of text
// about the views that are scored.
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "ingest/scene.h"

namespace tessera {

/// `names` joined by commas; of more than a dozen the first ones and how many more there are.
std::string listed_names(const std::vector<std::string>& names);

/// `list` was split at commas; those in a name of `known` are put back.
std::vector<std::string> whole_names(const std::vector<std::string>& list,
                                     const std::vector<std::string>& known);

/// What --held-out is to train on all cameras, where none is called so.
inline constexpr const char* kHeldOutNone = "none";

/// kTest for the named ones, kTrain for the others; `held_out` as of whole_names. Errors:
/// InputError that starts with `layout`: a name that is none of `cameras`, or all of them held out.
std::vector<Split> held_out_splits_of(const std::vector<std::string>& cameras,
                                      const std::vector<std::string>& held_out,
                                      const std::string& layout);

/// kTest for names 0, every, 2 · every … in the order of the names, kTrain for the others; 0: all
/// train. Errors: InputError: `every` is 1 or negative.
std::vector<Split> every_nth_split(const std::vector<std::string>& names, int64_t every);

/// The place that lies nearest to all others, the first of those that do within a fiftieth: a
/// camera there is held out by default, as its neighbours see what it sees. `centres`: not empty.
size_t innermost(const std::vector<glm::dvec3>& centres);

class TestViews {
 public:
  /// Looks at camera name and split; the pixels are not needed.
  void add(const Frame& frame);

  /// Views of the splits test and val.
  int64_t count() const;
  /// "will be scored: 24 test views (camera cam00)", or that nothing will be and how to change it.
  std::string text() const;

 private:
  struct Counts {
    int64_t all = 0, test = 0, val = 0;
  };
  /// "24 test views (camera cam00)"; empty where the split has none.
  std::string text_of(const char* split, int64_t Counts::*views) const;

  std::map<std::string, Counts> cameras_;
};

TestViews test_views_of(const Scene& scene);

}  // namespace tessera
