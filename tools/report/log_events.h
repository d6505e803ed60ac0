// The events of log.jsonl that are valid at the end of a training, and access to fields of JSON
// objects that may be missing.
#pragma once
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace tessera {

struct CurvePoint {
  int64_t step = 0;
  double seconds = 0;  // of steps and decisions until then; those of validation are not known
  double value = 0;
};

/// Over steps, ascending. A training that was resumed from an earlier step has each step once.
struct RunCurves {
  std::vector<CurvePoint> psnr_test, psnr_validation;  // dB
  std::vector<CurvePoint> loss;                        // mean over the steps of a line of the log
  std::vector<CurvePoint> num_static, num_dynamic;     // Gaussians
  std::vector<CurvePoint> bytes;                       // peak of the device's memory so far
};

/// {step, seconds, value}: arrays.
nlohmann::json to_json(const std::vector<CurvePoint>& curve);
/// {psnr_test, psnr_validation, loss, static, dynamic, memory} of these.
nlohmann::json to_json(const RunCurves& curves);

/// The events of a log in their order. A resumed training begins at the step of its checkpoint:
/// what the log has of later steps from before it is left out, but for warnings. Lines that are no
/// JSON object with an `event` are left out, too.
std::vector<nlohmann::json> log_events(const std::string& log);

RunCurves run_curves(const std::vector<nlohmann::json>& events);
/// [{step, text}]: reductions one by one, with the Gaussians {static: [before, after], dynamic},
/// density control in one sentence a set, and why training stopped.
nlohmann::json run_decisions(const std::vector<nlohmann::json>& events);

/// The field where `object` is an object that has it as a number that is finite.
std::optional<double> number_at(const nlohmann::json& object, const char* key);
/// The same for text; "" otherwise.
std::string text_at(const nlohmann::json& object, const char* key);
/// The same for a whole number; 0 otherwise.
int64_t count_at(const nlohmann::json& object, const char* key);
/// The field; null otherwise.
const nlohmann::json& field_at(const nlohmann::json& object, const char* key);
/// null where there is none.
nlohmann::json or_null(const std::optional<double>& value);

}  // namespace tessera
