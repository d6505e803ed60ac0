// Shell completion of commands, options and choices; all other arguments complete to files.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "tools/reference/reference.h"

namespace tessera {
namespace {

std::vector<std::string> typed_names(const CommandReference& command) {
  std::vector<std::string> names;
  for (const OptionReference& option : command.options)
    if (!option.is_argument) names.insert(names.end(), option.names.begin(), option.names.end());
  return names;
}

/// Inside single quotes of a shell.
std::string quoted(std::string text) {
  for (size_t i = 0; (i = text.find('\'', i)) != std::string::npos; i += 4)
    text.replace(i, 1, "'\\''");
  return "'" + text + "'";
}

}  // namespace

std::string bash_completion(const std::vector<CommandReference>& commands) {
  std::string names, cases;
  for (const CommandReference& command : commands) {
    names += (names.empty() ? "" : " ") + command.name;
    std::string choices;
    for (const OptionReference& option : command.options)
      if (!option.choices.empty() && !option.is_argument)
        choices +=
            fmt::format("        {}) COMPREPLY=($(compgen -W '{}' -- \"$word\")); return ;;\n",
                        fmt::join(option.names, "|"), fmt::join(option.choices, " "));
    cases += fmt::format(
        "    {})\n      case \"$before\" in\n{}      esac\n      options='{}'\n      ;;\n",
        command.name, choices, fmt::join(typed_names(command), " "));
  }
  return fmt::format(
      "# bash completion of tessera\n"
      "_tessera() {{\n"
      "  local word=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD-1]}} options=\n"
      "  if [ \"$COMP_CWORD\" -eq 1 ]; then\n"
      "    COMPREPLY=($(compgen -W '{} --help --version' -- \"$word\"))\n"
      "    return\n"
      "  fi\n"
      "  case \"${{COMP_WORDS[1]}}\" in\n{}  esac\n"
      "  if [[ $word == -* ]]; then\n"
      "    COMPREPLY=($(compgen -W \"$options\" -- \"$word\"))\n"
      "  else\n"
      "    COMPREPLY=($(compgen -f -- \"$word\"))\n"
      "  fi\n"
      "}}\n"
      "complete -o filenames -F _tessera tessera\n",
      names, cases);
}

std::string zsh_completion(const std::vector<CommandReference>& commands) {
  const auto spec = [](std::string text) {  // a description inside [...]
    for (const char c : {'[', ']', ':'})
      for (size_t i = 0; (i = text.find(c, i)) != std::string::npos; i += 2) text.insert(i, "\\");
    return text;
  };
  std::string list, cases;
  for (const CommandReference& command : commands) {
    list += fmt::format("    {}\n", quoted(command.name + ":" + spec(first_line(command.doc))));
    std::string options;
    for (const OptionReference& option : command.options) {
      if (option.is_argument) continue;
      for (const std::string& name : option.names) {
        std::string value;
        if (!option.choices.empty())
          value = fmt::format(":value:({})", fmt::join(option.choices, " "));
        else if (!option.placeholder.empty())
          value = ":value:_files";
        options += fmt::format(" \\\n        {}",
                               quoted(name + "[" + spec(first_line(option.doc)) + "]" + value));
      }
    }
    cases += fmt::format("    {})\n      _arguments{} \\\n        '*:file:_files'\n      ;;\n",
                         command.name, options);
  }
  return fmt::format(
      "#compdef tessera\n"
      "_tessera() {{\n"
      "  local -a commands=(\n{}  )\n"
      "  if (( CURRENT == 2 )); then\n"
      "    _describe command commands\n"
      "    return\n"
      "  fi\n"
      "  local command=${{words[2]}}\n"
      "  shift words\n"
      "  (( CURRENT-- ))\n"
      "  case $command in\n{}  esac\n"
      "}}\n"
      "_tessera \"$@\"\n",
      list, cases);
}

std::string fish_completion(const std::vector<CommandReference>& commands) {
  std::string text = "# fish completion of tessera\n";
  for (const CommandReference& command : commands)
    text += fmt::format("complete -c tessera -f -n __fish_use_subcommand -a {} -d {}\n",
                        command.name, quoted(first_line(command.doc)));
  for (const CommandReference& command : commands)
    for (const OptionReference& option : command.options) {
      if (option.is_argument) continue;
      std::string names;
      for (const std::string& name : option.names)
        names += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
      std::string value;
      if (!option.choices.empty())
        value = fmt::format(" -x -a '{}'", fmt::join(option.choices, " "));
      else if (!option.placeholder.empty())
        value = " -r";
      text += fmt::format("complete -c tessera -n '__fish_seen_subcommand_from {}'{}{} -d {}\n",
                          command.name, names, value, quoted(first_line(option.doc)));
    }
  return text;
}

}  // namespace tessera
