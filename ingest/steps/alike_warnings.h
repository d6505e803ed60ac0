// Says once what holds for many cameras.
#pragma once
#include <string>
#include <vector>

namespace tessera {

/// The lines, but of three or more that differ in the name of a camera alone the first, with the
/// names of the others: "… (likewise: cam01, cam02)". `cameras`: all names.
std::vector<std::string> merged_alike(const std::vector<std::string>& lines,
                                      const std::vector<std::string>& cameras);

}  // namespace tessera
