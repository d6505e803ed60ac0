// What: the table of backends by name.
// Not: choosing for the user.
#include "tools/backend_choice.h"

#include <fmt/format.h>

#include "kernels/base/errors.h"

namespace tessera {

std::unique_ptr<Backend> make_backend(const std::string& name) {
  if (name == "cpu") return make_cpu_backend();
  if (name == "cuda") return make_cuda_backend();
  throw InputError(fmt::format("unknown backend '{}'; choose cpu or cuda", name));
}

}  // namespace tessera
