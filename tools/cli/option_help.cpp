// Two columns from the entries of option_reference.h.
#include "tools/cli/option_help.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <sstream>

#include "tools/cli/option_reference.h"

namespace tessera {
namespace {

constexpr size_t kNames = 30;  // width of the first column

size_t line_width() {
  constexpr size_t kNarrowest = 80, kWidest = 110, kElsewhere = 100;
  winsize size{};
  if (isatty(STDOUT_FILENO) != 1 || ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 ||
      size.ws_col == 0)
    return kElsewhere;
  return std::clamp(size_t(size.ws_col), kNarrowest, kWidest);
}

/// `text` in lines of the second column; lines that it has already are kept, with their indent.
std::string wrapped(const std::string& text) {
  const size_t width = line_width() - kNames - 1;
  std::istringstream lines(text);
  std::string result, line;
  while (std::getline(lines, line)) {
    const size_t first = line.find_first_not_of(' ');
    const std::string indent(first == std::string::npos ? 0 : first, ' ');
    std::istringstream words(line);
    std::string word, filled = indent;
    while (words >> word) {
      if (filled.size() + 1 + word.size() > width && filled.size() > indent.size()) {
        result += filled + "\n" + std::string(kNames, ' ');
        filled = indent;
      }
      filled += (filled.size() > indent.size() ? " " : "") + word;
    }
    result += filled + "\n" + std::string(kNames, ' ');
  }
  return result.substr(0, result.find_last_not_of(" \n") + 1);
}

std::string entry(const std::string& names, const std::string& text) {
  const std::string first = "  " + names;
  if (first.size() + 1 < kNames) return fmt::format("{:<{}}{}\n", first, kNames, wrapped(text));
  return fmt::format("{}\n{}{}\n", first, std::string(kNames, ' '), wrapped(text));
}

std::string entry(const OptionReference& option) {
  std::string names = fmt::format("{}", fmt::join(option.names, ", "));
  if (!option.placeholder.empty()) names += " " + option.placeholder;
  std::string text = option.doc;
  if (option.row != nullptr && *option.row->example != '\0')
    text += fmt::format(", for example {}", option.row->example);
  if (option.required) text += " (required)";
  if (!option.defaults.empty()) text += fmt::format(" [{}]", option.defaults);
  return entry(names, text);
}

class HelpFormatter : public CLI::Formatter {
 public:
  std::string make_option(const CLI::Option* option, bool) const override {
    return entry(option_reference(*option));
  }

  std::string make_help(const CLI::App* app, std::string name,
                        CLI::AppFormatMode mode) const override {
    if (mode == CLI::AppFormatMode::Sub) return make_expanded(app);
    return make_description(app) + make_usage(app, std::move(name)) + make_positionals(app) +
           groups_text(app, mode) + make_subcommands(app, mode);
  }

  std::string make_expanded(const CLI::App* app) const override {
    return fmt::format("tessera {}\n{}{}\n", app->get_name(), make_description(app),
                       groups_text(app, CLI::AppFormatMode::All));
  }

  std::string make_description(const CLI::App* app) const override {
    return app->get_description() + "\n";
  }

  std::string make_subcommand(const CLI::App* command) const override {
    return entry(command->get_name(), command->get_description());
  }

 private:
  static std::string groups_text(const CLI::App* app, CLI::AppFormatMode mode) {
    const bool all = mode != CLI::AppFormatMode::Normal;
    std::string text;
    size_t left_out = 0;
    for (const std::string& group : app->get_groups()) {
      std::string entries;
      for (const CLI::Option* option : app->get_options()) {
        if (group.empty() || option->get_group() != group || !option->nonpositional()) continue;
        const OptionReference reference = option_reference(*option);
        if (reference.row != nullptr && !reference.row->common && !all)
          ++left_out;
        else
          entries += entry(reference);
      }
      if (!entries.empty()) text += fmt::format("\n{}:\n{}", group, entries);
    }
    if (left_out > 0)
      text += fmt::format("\n{} more options: tessera {} --help-all\n", left_out, app->get_name());
    return text;
  }
};

}  // namespace

std::shared_ptr<CLI::Formatter> help_formatter() {
  return std::make_shared<HelpFormatter>();
}

}  // namespace tessera
