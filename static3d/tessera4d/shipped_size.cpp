// What: encode, ask the manifest.
// Not: any file on disk.
#include "static3d/tessera4d/shipped_size.h"

#include <nlohmann/json.hpp>

namespace tessera {

ShippedSize shipped_size(const GaussianModel& model, const Tessera4dOptions& options) {
  const Tessera4dFile file = encode_tessera4d(model, options);
  ShippedSize size;
  size.bytes = int64_t(single_tessera4d(file).size());
  GaussianModel rules;
  size.account = shipped_breakdown(
      manifest_from(nlohmann::json::parse(file.manifest), "the encoded model", rules), size.bytes);
  return size;
}

}  // namespace tessera
