// The options --backend and --gpu, and the warning when the CPU is used although CUDA might have
// been expected. tools/session/device_choice.h makes the choice.
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "kernels/backend.h"

namespace CLI {
class App;
}

namespace tessera {

/// --backend and --gpu; `backend` becomes "auto", "cpu", "cuda", with a number "auto:1".
void add_backend_options(CLI::App& command, std::string& backend);

/// The words that say the same.
std::vector<std::string> backend_words(const std::string& backend);

/// --gpus.
void add_gpus_option(CLI::App& command, int64_t& gpus);
/// Errors: InputError: several cards for a training on the CPU, or on one card that is named.
void check_gpus(int64_t gpus, const std::string& backend);

/// As choose_backend; the first time in a program warns where the CPU is used and CUDA might have
/// been expected.
std::unique_ptr<Backend> make_backend(const std::string& backend);
/// Whether it would be a CUDA device. Warns and fails as make_backend, but makes nothing.
bool is_cuda_chosen(const std::string& backend);

/// Once a program.
void warn_of_unused_cuda(const std::string& reason);

}  // namespace tessera
