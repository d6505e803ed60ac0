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

/// What --help shows of a command that has more options than a screen has lines.
struct ShortHelp {
  const char* command;
  std::vector<const char*> examples;  // a command line each, with what it does
  std::vector<const char*> options;   // with dashes, in the order in which they are shown
};

/// Nothing: --help shows all options of that command.
const ShortHelp* short_help(const std::string& command) {
  static const std::vector<ShortHelp> rows{
      {"run",
       {"tessera run dance -o out --preset fast --scale 0.5    a first result, quickly",
        "tessera run dance -o out_full                         preset balanced, full size",
        "tessera run dance -o out --frames 60 --view           60 frames, watched in a browser"},
       {"--out", "--preset", "--scale", "--frames", "--start", "--cameras", "--held-out", "--poses",
        "--sync", "--masks", "--cloud", "--motion", "--iterations", "--max-gaussians", "--windows",
        "--export-frames", "--view", "--overwrite", "--backend"}},
      {"train",
       {"tessera train scene -o run --preset fast              a first result, quickly",
        "tessera train scene -o run --iterations 20000         the same command resumes it",
        "tessera train scene -o run --max-bytes 5MB            the best model of that size"},
       {"--out", "--preset", "--iterations", "--batch", "--seed", "--motion", "--init-points",
        "--background", "--sh-degree", "--exposure", "--validation-share", "--max-gaussians",
        "--max-bytes", "--within-db", "--windows", "--view", "--resume", "--overwrite",
        "--backend"}},
      {"batch",
       {"tessera batch captures -o out --preset fast,balanced  all captures by two presets",
        "tessera batch captures -o out --seeds 1,2,3 --dry-run what would be done",
        "tessera batch -o out                                  continues where it was stopped"},
       {"--out", "--preset", "--seeds", "--steps", "--budgets", "--exports", "--jobs", "--gpus",
        "--windows", "--dry-run", "--profile", "--part", "--scale", "--frames", "--held-out",
        "--motion", "--max-gaussians"}}};
  for (const ShortHelp& row : rows)
    if (command == row.command) return &row;
  return nullptr;
}

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

std::string names_of(const OptionReference& option) {
  const std::string names = fmt::format("{}", fmt::join(option.names, ", "));
  return option.placeholder.empty() ? names : names + " " + option.placeholder;
}

/// The option in a line or two: what it is, without cases, and the default of a training that is
/// asked for nothing.
std::string short_entry(OptionReference option) {
  std::string text = first_line(option.doc);
  text.resize(std::min(text.find("; "), text.size()));
  if (!option.choices.empty()) {
    text.resize(std::min(text.find(':'), text.size()));
    option.placeholder.clear();
    text += fmt::format(": {}", fmt::join(option.choices, ", "));
  }
  if (option.required) text += " (required)";
  if (!option.defaults.empty())
    text += fmt::format(" [{}]", option.defaults.substr(0, option.defaults.find(';')));
  return entry(names_of(option), text);
}

std::string entry(const OptionReference& option) {
  std::string text = option.doc;
  if (option.row != nullptr && *option.row->example != '\0')
    text += fmt::format(", for example {}", option.row->example);
  if (option.required) text += " (required)";
  if (!option.defaults.empty()) text += fmt::format(" [{}]", option.defaults);
  return entry(names_of(option), text);
}

class HelpFormatter : public CLI::Formatter {
 public:
  std::string make_option(const CLI::Option* option, bool) const override {
    return entry(option_reference(*option));
  }

  std::string make_help(const CLI::App* app, std::string name,
                        CLI::AppFormatMode mode) const override {
    if (mode == CLI::AppFormatMode::Sub) return make_expanded(app);
    const std::string head =
        make_description(app) + make_usage(app, std::move(name)) + make_positionals(app);
    const ShortHelp* const brief =
        mode == CLI::AppFormatMode::Normal ? short_help(app->get_name()) : nullptr;
    if (brief != nullptr) return head + short_text(app, *brief);
    return head + groups_text(app) + make_subcommands(app, mode);
  }

  std::string make_expanded(const CLI::App* app) const override {
    return fmt::format("tessera {}\n{}{}\n", app->get_name(), make_description(app),
                       groups_text(app));
  }

  std::string make_description(const CLI::App* app) const override {
    return app->get_description() + "\n";
  }

  std::string make_subcommand(const CLI::App* command) const override {
    return entry(command->get_name(), command->get_description());
  }

 private:
  static std::string short_text(const CLI::App* app, const ShortHelp& brief) {
    std::string text = "\nExamples:\n";
    for (const char* example : brief.examples) text += fmt::format("  {}\n", example);
    text += "\nOptions:\n";
    for (const char* name : brief.options)
      text += short_entry(option_reference(*app->get_option(name)));
    const size_t others = app->get_options().size() - brief.options.size();
    return text +
           fmt::format("\n{} more options: tessera {} --help-all\n", others, app->get_name());
  }

  static std::string groups_text(const CLI::App* app) {
    std::string text;
    for (const std::string& group : app->get_groups()) {
      std::string entries;
      for (const CLI::Option* option : app->get_options())
        if (!group.empty() && option->get_group() == group && option->nonpositional())
          entries += entry(option_reference(*option));
      if (!entries.empty()) text += fmt::format("\n{}:\n{}", group, entries);
    }
    return text;
  }
};

}  // namespace

std::shared_ptr<CLI::Formatter> help_formatter() {
  return std::make_shared<HelpFormatter>();
}

std::string first_steps() {
  return "  tessera synth room --layout videos -o capture    a small capture to begin with\n"
         "  tessera doctor CAPTURE                           what a capture has and lacks\n"
         "  tessera run CAPTURE -o OUT --preset fast         from videos to a page that plays\n"
         "  tessera view OUT                                 shows it in a browser\n";
}

}  // namespace tessera
