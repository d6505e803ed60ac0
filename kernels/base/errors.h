// The kinds of failure: wrong data of the user (InputError), the device (DeviceError), non-finite
// numbers of a training (NumericalError), and bugs (check). Only tools/ turns them into exit codes.
// The limits of counts with 32-bit indices are here as well.
#pragma once
#include <cstdint>
#include <stdexcept>
#include <string>

namespace tessera {

/// The user's data or usage is wrong. The message names the thing and the remedy, in one line.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A device statement failed. The message names the statement, the sizes and the free memory.
class DeviceError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The numbers went wrong during training: a non-finite loss or gradient, the parameter named.
class NumericalError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Asserts a condition that only a bug can break; always on. Errors: std::logic_error.
inline void check(bool condition, const char* what) {
  if (!condition) throw std::logic_error(std::string("internal error: ") + what);
}

/// Errors: InputError where more than 2³¹ − 1 of `what` are to be numbered.
inline void check_count(int64_t count, const char* what, const char* remedy) {
  if (count <= INT32_MAX) return;
  throw InputError(std::to_string(count) + " " + what + " in one batch, at most " +
                   std::to_string(INT32_MAX) + " are supported; use " + remedy);
}

inline void check_gaussian_count(int64_t count) {
  check_count(count, "Gaussians", "fewer (--max-gaussians)");
}
inline void check_splat_count(int64_t count) {
  check_count(count, "splats", "a smaller batch or fewer Gaussians (--max-gaussians)");
}

}  // namespace tessera
