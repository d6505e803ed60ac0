// The start of a program by posix_spawn.
#include "tools/cli/background_program.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spawn.h>

#include <cerrno>
#include <string_view>

extern char** environ;

namespace tessera {

pid_t start_in_background(const std::filesystem::path& program,
                          const std::vector<std::string>& words, const ProgramPlace& place) {
  std::vector<char*> argv;
  for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  // not of the terminal's foreground group: it may not read from there
  posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  if (place.output != STDOUT_FILENO)
    posix_spawn_file_actions_adddup2(&files, place.output, STDOUT_FILENO);
  if (place.errors != STDERR_FILENO)
    posix_spawn_file_actions_adddup2(&files, place.errors, STDERR_FILENO);
  if (!place.folder.empty()) posix_spawn_file_actions_addchdir_np(&files, place.folder.c_str());
  std::vector<char*> environment;
  std::string variable = place.variable;
  const std::string name = variable.substr(0, variable.find('=') + 1);
  for (char** entry = environ; *entry != nullptr; ++entry)
    if (name.empty() || !std::string_view(*entry).starts_with(name)) environment.push_back(*entry);
  if (!name.empty()) environment.push_back(variable.data());
  environment.push_back(nullptr);
  pid_t child = -1;
  const int error =
      posix_spawn(&child, program.c_str(), &files, &attributes, argv.data(), environment.data());
  posix_spawn_file_actions_destroy(&files);
  posix_spawnattr_destroy(&attributes);
  if (error == 0) return child;
  errno = error;
  return -1;
}

std::string shell_line(const std::vector<std::string>& arguments) {
  constexpr const char* kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_./=,:+@%";
  const auto quoted = [](const std::string& argument) {
    std::string word;
    for (char c : argument) word += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return fmt::format("'{}'", word);
  };
  std::vector<std::string> words;
  for (const std::string& argument : arguments) {
    const bool plain = !argument.empty() && argument.find_first_not_of(kPlain) == std::string::npos;
    words.push_back(plain ? argument : quoted(argument));
  }
  return fmt::format("{}", fmt::join(words, " "));
}

std::filesystem::path this_program() {
  return std::filesystem::read_symlink("/proc/self/exe");
}

}  // namespace tessera
