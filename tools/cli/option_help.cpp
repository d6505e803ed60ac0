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

/// `words` in lines of the second column: `first` before the first line, `indent` before the
/// others.
std::string filled(std::istringstream& words, const std::string& first, const std::string& indent) {
  const size_t width = line_width() - kNames - 1;
  std::string text, word, line = first;
  bool is_empty = true;  // of words
  while (words >> word) {
    if (!is_empty && line.size() + 1 + word.size() > width) {
      text += line + "\n" + std::string(kNames, ' ');
      line = indent;
      is_empty = true;
    }
    line += (is_empty ? "" : " ") + word;
    is_empty = false;
  }
  return text + line;
}

/// `text` in lines of the second column. An indented line is a choice: its name, then its meaning.
std::string wrapped(const std::string& text) {
  constexpr size_t kChoice = 12;  // width of the name of a choice
  std::istringstream lines(text);
  std::string result, line;
  while (std::getline(lines, line)) {
    std::istringstream words(line);
    if (!result.empty()) result += "\n" + std::string(kNames, ' ');
    if (!line.starts_with("    ")) {
      result += filled(words, "", "");
      continue;
    }
    std::string name;
    words >> name;
    result += filled(words, fmt::format("  {:<{}}", name, kChoice), std::string(2 + kChoice, ' '));
  }
  return result;
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
