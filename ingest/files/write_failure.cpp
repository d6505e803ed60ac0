// What: the reasons of errno in two groups, and one message for each.
// Not: any retry.
#include "ingest/files/write_failure.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "kernels/base/errors.h"

namespace tessera {

bool path_is_at_fault(int reason) {
  constexpr std::array kOfThePath{EACCES, EPERM,  EROFS,     ENOENT,  ENOTDIR, EISDIR, ENAMETOOLONG,
                                  ELOOP,  EEXIST, ENOTEMPTY, ETXTBSY, EBUSY,   EXDEV,  EINVAL};
  return std::find(kOfThePath.begin(), kOfThePath.end(), reason) != kOfThePath.end();
}

void fail_to_write(const std::filesystem::path& path, int reason) {
  const std::string seen =
      fmt::format("{}: cannot be written ({})", path.string(), std::strerror(reason));
  if (path_is_at_fault(reason))
    throw InputError(seen + "; check the path and its permissions or choose another folder");
  throw WriteError(seen + "; free space or choose another folder");
}

}  // namespace tessera
