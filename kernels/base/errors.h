// What: the three kinds of failure: the user's data (InputError), the device (DeviceError), our bug
// (check). Not: exit codes; only tools/ turns these into 2, 1 and 1.
#pragma once
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

/// Asserts what only a bug of ours can break; always on. Errors: std::logic_error.
inline void check(bool condition, const char* what) {
  if (!condition) throw std::logic_error(std::string("internal error: ") + what);
}

}  // namespace tessera
