// What: lists on the command line name each thing once.
// Not: what the things are.
#pragma once
#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <vector>

#include "kernels/base/errors.h"

namespace tessera {

/// `option`: as the message begins. Errors: InputError naming what is there twice.
template <class T>
void refuse_repeats(std::vector<T> values, std::string_view option) {
  std::sort(values.begin(), values.end());
  const auto twice = std::adjacent_find(values.begin(), values.end());
  if (twice != values.end())
    throw InputError(fmt::format("{} has {} twice; name each once", option, *twice));
}

}  // namespace tessera
