// What: units of bytes.
// Not: how numbers of bytes are shown.
#pragma once

namespace tessera {

constexpr double kMiB = 1 << 20;

}  // namespace tessera
