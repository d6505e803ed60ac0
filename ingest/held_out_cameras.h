// What: names of cameras that the user holds out → the split of each camera.
// Not: the default choice, which is each layout's own.
#pragma once
#include <string>
#include <vector>

#include "ingest/scene.h"

namespace tessera {

/// `names` joined by commas; of more than a dozen the first ones and how many more there are.
std::string listed_names(const std::vector<std::string>& names);

/// kTest for the named ones, kTrain for the others. Errors: InputError that starts with `layout`: a
/// name that is none of `cameras`, or all of them held out.
std::vector<Split> held_out_splits_of(const std::vector<std::string>& cameras,
                                      const std::vector<std::string>& held_out,
                                      const std::string& layout);

}  // namespace tessera
