// What: names of cameras that the user holds out, or every Nth image → the split of each.
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

/// kTest for names 0, every, 2 · every … in the order of the names, kTrain for the others; 0: all
/// train. Errors: InputError: `every` is 1 or negative.
std::vector<Split> every_nth_split(const std::vector<std::string>& names, int64_t every);

}  // namespace tessera
