// Compares paths after links are resolved: whether one folder is, contains or lies in another.
#include "tools/cli/output_place.h"

#include <fmt/format.h>

#include <system_error>

#include "kernels/base/errors.h"
#include "tools/session/model_scene.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

/// Whether `inner` is the folder `outer` or lies in it; `inner` need not exist.
bool lies_in(const fs::path& inner, const fs::path& outer) {
  std::error_code absent;
  fs::path folder = fs::weakly_canonical(fs::absolute(inner), absent);
  while (!folder.empty()) {
    if (fs::equivalent(folder, outer, absent)) return true;
    if (folder == folder.parent_path()) break;
    folder = folder.parent_path();
  }
  return false;
}

}  // namespace

void check_output_outside(const fs::path& out, const fs::path& input) {
  std::error_code absent;
  if (fs::equivalent(out, input, absent))
    throw InputError(
        fmt::format("{}: is the input itself, which is never written to; choose another folder "
                    "with -o",
                    out.string()));
  if (lies_in(out, input))
    throw InputError(
        fmt::format("{}: lies in {}, which is the input and never written to; choose a folder "
                    "outside of it with -o",
                    out.string(), input.string()));
}

void check_output_apart(const fs::path& out, const fs::path& input) {
  check_output_outside(out, input);
  if (fs::exists(input) && lies_in(input, out))
    throw InputError(
        fmt::format("{}: contains the input {}, which would lie among the results; choose a folder "
                    "beside it with -o",
                    out.string(), input.string()));
}

void check_output_of_model(const fs::path& out, const fs::path& model, const fs::path& cameras) {
  if (fs::is_directory(cameras)) check_output_outside(out, cameras);
  const fs::path run = fs::is_directory(model) ? model : fs::absolute(model).parent_path();
  const std::string scene = scene_of_model(model);
  if (!scene.empty() && !lies_in(out, run)) check_output_outside(out, scene);
}

void check_may_replace(const fs::path& folder, const char* what, bool exists, bool overwrite) {
  if (exists && !overwrite)
    throw InputError(fmt::format(
        "{}: holds {} already; pass --overwrite to replace it, or choose another folder with -o",
        folder.string(), what));
}

}  // namespace tessera
