// Joins the rows of the option table from their parts.
#include "recon4d/options/option_rows.h"

#include <utility>

namespace tessera {

std::vector<TrainOption> OptionRows::all() {
  OptionRows rows;
  rows.add_model();
  rows.add_motion();
  rows.add_optimisation();
  rows.add_growth();
  return std::move(rows.rows_);
}

OptionRows& OptionRows::add(const char* key, Member member, OptionRange range, const char* source,
                            const char* doc) {
  rows_.push_back({.key = key,
                   .member = std::move(member),
                   .low = range.low,
                   .high = range.high,
                   .doc = doc,
                   .source = source,
                   .group = group_,
                   .unit = range.unit});
  return *this;
}

}  // namespace tessera
