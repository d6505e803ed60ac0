// One page for the program and one for each command, in man(7).
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "tools/reference/reference.h"
#include "tools/session/version.h"

namespace tessera {
namespace {

/// Text of roff: backslashes, dashes, and marks at the beginning of a line are escaped.
std::string roff(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '\\')
      result += "\\e";
    else if (c == '-')
      result += "\\-";
    else if ((c == '.' || c == '\'') && (result.empty() || result.back() == '\n'))
      result += std::string("\\&") + c;
    else
      result += c;
  }
  return result;
}

std::string heading(const std::string& name, const std::string& doc) {
  return fmt::format(".TH {} 1 \"\" \"tessera {}\" \"User Commands\"\n.SH NAME\n{} \\- {}\n", name,
                     kVersionText, roff(name), roff(doc));
}

std::string command_page(const CommandReference& command) {
  std::string text = heading("tessera-" + command.name, command.doc), group;
  text += fmt::format(".SH SYNOPSIS\n.B tessera {}\n", roff(command.name));
  for (const OptionReference& option : command.options)
    if (option.is_argument)
      text += option.required ? fmt::format(".I {}\n", roff(option.names.front()))
                              : fmt::format("[\\fI{}\\fR]\n", roff(option.names.front()));
  text += "[\\fIoptions\\fR]\n.SH DESCRIPTION\n" + roff(command.doc) + ".\n.SH OPTIONS\n";
  for (const OptionReference& option : command.options) {
    if (option.row != nullptr && option.group != group) {
      group = option.group;
      text += fmt::format(".SS {}\n", roff(group));
    }
    std::vector<std::string> names;
    for (const std::string& name : option.names)
      names.push_back(option.is_argument ? "\\fI" + roff(name) + "\\fR"
                                         : "\\fB" + roff(name) + "\\fR");
    text += fmt::format(".TP\n{}", fmt::join(names, ", "));
    if (!option.placeholder.empty()) text += fmt::format(" \\fI{}\\fR", roff(option.placeholder));
    text += "\n" + roff(first_line(option.doc)) + ".\n";
    if (!option.choices.empty() && option.row == nullptr)
      text += roff(fmt::format("One of {}.", fmt::join(option.choices, ", "))) + "\n";
    if (!option.defaults.empty()) text += roff(fmt::format("Default: {}.", option.defaults)) + "\n";
  }
  return text + ".SH SEE ALSO\n.BR tessera (1)\n";
}

std::string program_page(const std::vector<CommandReference>& commands) {
  std::string text = heading("tessera", "multi-view video to 4D Gaussians that play");
  text += ".SH SYNOPSIS\n.B tessera\n.I command\n[\\fIoptions\\fR]\n.SH COMMANDS\n";
  for (const CommandReference& command : commands)
    text += fmt::format(".TP\n\\fB{}\\fR\n{}.\n", roff(command.name), roff(command.doc));
  text +=
      ".SH EXIT STATUS\n.TP\n0\nDone.\n.TP\n1\nFailed.\n.TP\n2\nBad usage or bad input.\n"
      ".TP\n65\n\\fBtrain \\-\\-resume\\fR refuses the checkpoint.\n"
      ".TP\n75\nStopped on request with a checkpoint; run the command again to resume.\n"
      ".TP\n130\nInterrupted.\n.SH SEE ALSO\n";
  std::string others;
  for (const CommandReference& command : commands)
    others +=
        (others.empty() ? "" : " ,\n") + fmt::format(".BR tessera\\-{} (1)", roff(command.name));
  return text + others + "\n";
}

}  // namespace

ReferencePages man_pages(const std::vector<CommandReference>& commands) {
  ReferencePages pages = {{"tessera.1", program_page(commands)}};
  for (const CommandReference& command : commands)
    pages["tessera-" + command.name + ".1"] = command_page(command);
  return pages;
}

}  // namespace tessera
