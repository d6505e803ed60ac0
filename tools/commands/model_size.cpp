// What: which accounts there are.
// Not: printing.
#include "tools/commands/model_size.h"

#include <nlohmann/json.hpp>

#include "static3d/tessera4d/model_histograms.h"
#include "tools/export/in_time.h"

namespace tessera {

nlohmann::json model_size(const std::string& path, const ModelInput& input, bool with_shipped) {
  nlohmann::json result = to_json(histograms_of(input.model), input.model.time_axis);
  result["account"]["memory"] = to_json(memory_breakdown(input.model));
  if (!input.shipped && !with_shipped) return result;
  nlohmann::json shipped =
      to_json(input.shipped ? *input.shipped : shipped_size_of(path, input.model).account);
  shipped["encoded_for_this"] = !input.shipped;
  result["account"]["shipped"] = std::move(shipped);
  return result;
}

}  // namespace tessera
