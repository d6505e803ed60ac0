// Adds the two options and prints the warning.
#include "tools/cli/backend_options.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <utility>

#include "kernels/base/errors.h"
#include "tools/cli/terminal.h"
#include "tools/session/device_choice.h"

namespace tessera {

void add_backend_options(CLI::App& command, std::string& backend) {
  command
      .add_option("--backend", backend, "auto (a CUDA device where one can be used), cpu or cuda")
      ->default_str(backend);
  // after --backend: options are taken in this order
  command
      .add_option_function<std::string>(
          "--gpu", [&backend](const std::string& number) { backend += ":" + number; },
          "CUDA device, of those in CUDA_VISIBLE_DEVICES; default: 0")
      ->type_name("N");
}

std::vector<std::string> backend_words(const std::string& backend) {
  const BackendWish wish = parse_backend(backend);
  std::vector<std::string> words{"--backend", wish.name};
  if (wish.gpu) words.insert(words.end(), {"--gpu", fmt::format("{}", *wish.gpu)});
  return words;
}

void add_gpus_option(CLI::App& command, int64_t& gpus) {
  command.add_option("--gpus", gpus, "cards that train windows at once")
      ->capture_default_str()
      ->check(CLI::Range(int64_t{1}, int64_t{64}));
}

void check_gpus(int64_t gpus, const std::string& backend) {
  const BackendWish wish = parse_backend(backend);
  if (gpus < 2 || (wish.name != "cpu" && !wish.gpu)) return;
  throw InputError(fmt::format(
      "--gpus {} is for the CUDA cards from 0 on, and {}; drop one of the two", gpus,
      wish.gpu ? fmt::format("--gpu {} names one", *wish.gpu) : std::string("--backend is cpu")));
}

void warn_of_unused_cuda(const std::string& reason) {
  static bool warned = false;
  if (!std::exchange(warned, true))
    warn(fmt::format("CUDA is not used: {}; the CPU is used, which is much slower", reason));
}

std::unique_ptr<Backend> make_backend(const std::string& backend) {
  ChosenBackend chosen = choose_backend(backend);
  if (chosen.choice.leaves_cuda_unused()) warn_of_unused_cuda(chosen.choice.reason);
  return std::move(chosen.backend);
}

bool is_cuda_chosen(const std::string& backend) {
  const DeviceChoice choice = find_backend(backend);
  if (choice.leaves_cuda_unused()) warn_of_unused_cuda(choice.reason);
  return choice.cuda;
}

}  // namespace tessera
