// The bytes of a model by component, of static and dynamic Gaussians apart, in memory and in its
// Tessera 4D file, with the size of that file.
#pragma once
#include <array>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string_view>

#include "static3d/tessera4d/tessera4d.h"

namespace tessera {

/// What a number of a Gaussian is for. kTime: what a dynamic Gaussian has besides a static one:
/// centre and length of its life, its motion (velocity or the second quaternion of a pair), levels
/// of time of its colour.
enum class Component { kMeans, kRotations, kScales, kOpacity, kColour, kTime };
inline constexpr int kComponents = 6;

const char* component_name(Component component);  // "means", …
/// Of a parameter group of either set; of a stream of the Tessera 4D file, of any block.
Component component_of(Group group);
Component component_of_stream(std::string_view name);

/// Of the Gaussians of one set.
struct ComponentBytes {
  int64_t count = 0;                         // Gaussians
  std::array<int64_t, kComponents> bytes{};  // by Component

  int64_t total() const;
};

struct SizeBreakdown {
  ComponentBytes fixed, moving;
  int64_t environment = 0;  // in memory: the environment map; files do not hold it
  int64_t container = 0;    // of a file: manifest and header

  /// All bytes.
  int64_t total() const;
};

/// Float values as they are rendered, without optimizer state.
SizeBreakdown memory_breakdown(const GaussianModel& model);
/// `bytes`: of the whole file, manifest and header with it (Tessera4dInput::bytes).
SizeBreakdown shipped_breakdown(const Tessera4dManifest& manifest, int64_t bytes);

/// `bytes`, container_bits, environment_bits; `static`, `dynamic` and `all`, each with `gaussians`,
/// `bits` of every component and their `sum`, and the same as `bits_per_gaussian` (null without
/// Gaussians).
nlohmann::json to_json(const SizeBreakdown& account);

struct ShippedSize {
  int64_t bytes = 0;      // of the file
  SizeBreakdown account;  // which adds up to `bytes`
};

/// Of the single file that export would write with these options, encoded in memory; what the
/// format leaves out (never drawn, not finite) costs nothing. The defaults are those of `tessera
/// export`, but for the rig's cameras and its frame rate, which only the caller has: about 200
/// bytes a camera. Cost: three seconds of one core for 100,000 Gaussians. Errors: as
/// encode_tessera4d.
ShippedSize shipped_size(const GaussianModel& model, const Tessera4dOptions& options = {});

}  // namespace tessera
