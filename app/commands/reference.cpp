// SPDX-License-Identifier: MIT
// `airclay reference FORMAT`: prints a man page, shell completions or the table in app/docs/commands.md,
// derived from the options themselves. Hidden: the build calls it.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <cstdio>
#include <memory>
#include <sstream>

#include "app/cli/command.h"
#include "engine/core/error.h"

namespace airclay {
namespace {

/// An option as the reference describes it.
struct OptionText {
  std::vector<std::string> names;  ///< "--out", "-h"; empty: positional
  std::string value;               ///< "FILE.obj"; empty: a flag
  std::string description;
  std::vector<std::string> choices;  ///< the only values allowed; empty: any
  bool positional = false, required = false;
};

struct CommandText {
  std::string name, description;
  std::string notes, examples;  ///< from the footer of --help: its text, and its indented lines
  std::vector<OptionText> options;
  std::vector<CommandText> subcommands;
};

/// "push|pull|FILE" names the choices: the parts in lower case.
std::vector<std::string> choicesIn(const std::string& type) {
  std::vector<std::string> choices;
  if (type.find('|') == std::string::npos) return choices;
  std::istringstream list(type);
  for (std::string choice; std::getline(list, choice, '|');)
    if (std::none_of(choice.begin(), choice.end(), [](unsigned char c) { return std::isupper(c); }))
      choices.push_back(choice);
  return choices;
}

OptionText textOf(const CLI::Option& option) {
  OptionText text;
  for (const std::string& name : option.get_snames()) text.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) text.names.push_back("--" + name);
  text.positional = option.get_positional();
  text.required = option.get_required();
  text.description = option.get_description();
  const bool is_flag = option.get_items_expected_max() == 0;
  if (!is_flag) {
    text.choices = choicesIn(option.get_type_name());
    text.value = option.get_type_name().substr(0, option.get_type_name().find(':'));
    if (text.positional) text.value = option.get_name(true);
    if (text.positional && option.get_items_expected_max() > 1) text.value += "...";
    if (text.value.empty()) text.value = "VALUE";
  }
  return text;
}

/// Options and subcommands in a hidden group are left out.
CommandText textOf(const CLI::App& command) {
  CommandText text;
  text.name = command.get_name();
  text.description = command.get_description();
  std::istringstream footer(command.get_footer());
  for (std::string line; std::getline(footer, line);)
    if (line.starts_with("  "))
      text.examples += line.substr(2) + "\n";
    else if (!line.empty() && !line.ends_with(":"))
      text.notes += line + "\n";
  for (const CLI::Option* option : command.get_options({}))
    if (!option->get_group().empty()) text.options.push_back(textOf(*option));
  // Positional arguments first, in their order.
  std::stable_partition(text.options.begin(), text.options.end(),
                        [](const OptionText& o) { return o.positional; });
  for (const CLI::App* child : command.get_subcommands([](const CLI::App*) { return true; }))
    if (!child->get_group().empty()) text.subcommands.push_back(textOf(*child));
  return text;
}

/// "airclay subdivide CAGE --out FILE.obj [OPTIONS]"
std::string usageOf(const std::string& program, const CommandText& command) {
  std::string usage = program + " " + command.name;
  for (const OptionText& option : command.options)
    if (option.positional) usage += option.required ? " " + option.value : " [" + option.value + "]";
  for (const OptionText& option : command.options)
    if (!option.positional && option.required) usage += " " + option.names.back() + " " + option.value;
  if (!command.subcommands.empty()) usage += " COMMAND";
  return usage + " [OPTIONS]";
}

std::string joined(const std::vector<std::string>& parts, const std::string& separator) {
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : separator) + part;
  return text;
}

std::string headOf(const OptionText& option) {
  if (option.positional) return option.value;
  return joined(option.names, ", ") + (option.value.empty() ? "" : " " + option.value);
}

/// Calls `visit` with every command and subcommand and its path.
template <typename Visit>
void forEachCommand(const CommandText& command, const std::string& path, const Visit& visit) {
  for (const CommandText& child : command.subcommands) {
    visit(path, child);
    forEachCommand(child, path + " " + child.name, visit);
  }
}

// ------------------------------------------------------------------------------------------------ man page

std::string roff(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '\\')
      escaped += "\\e";
    else if (c == '-')
      escaped += "\\-";
    else
      escaped += c;
  }
  return escaped.starts_with(".") || escaped.starts_with("'") ? "\\&" + escaped : escaped;
}

std::string manPage(const CommandText& program) {
  std::ostringstream out;
  out << ".TH AIRCLAY 1 \"\" \"airclay " << AIRCLAY_VERSION << "\" \"User Commands\"\n"
      << ".SH NAME\nairclay \\- sculpt virtual clay with a bare hand, seen by a few ordinary cameras\n"
      << ".SH SYNOPSIS\n.B airclay\n.I COMMAND\n[\\fIOPTIONS\\fR]\n"
      << ".SH DESCRIPTION\n"
      << roff(program.description) << "\n.SH COMMANDS\n";
  forEachCommand(program, "airclay", [&](const std::string& path, const CommandText& command) {
    out << ".SS " << roff(usageOf(path, command)) << "\n" << roff(command.description) << "\n";
    for (const OptionText& option : command.options)
      if (option.names.empty() || option.names.back() != "--help")
        out << ".TP\n.B " << roff(headOf(option)) << "\n" << roff(option.description) << "\n";
    if (!command.notes.empty()) out << ".PP\n" << roff(command.notes);
  });
  out << ".SH EXIT STATUS\n"
      << ".TP\n.B 0\nsuccess\n.TP\n.B 1\nbad input, or a failed comparison\n.TP\n.B 2\nwrong usage\n"
      << ".TP\n.B 3\nno usable Vulkan device\n.TP\n.B 128+N\ninterrupted by signal N\n"
      << ".SH ENVIRONMENT\n"
      << ".TP\n.B AIRCLAY_VALIDATION\n1: run the Vulkan validation layer and print what it finds\n"
      << ".TP\n.B XDG_CONFIG_HOME, XDG_STATE_HOME\nwhere the studio keeps its settings and unsaved "
         "documents\n"
      << ".SH EXAMPLES\n.nf\n"
      << "airclay demo\nairclay sculpt TAKE \\-\\-clay vase\nairclay track TAKE \\-\\-poses hand.tum\n"
      << "airclay export pot.clay \\-\\-out pot.stl\n.fi\n";
  return out.str();
}

// ---------------------------------------------------------------------------------------------- completions

std::vector<std::string> completionsOf(const CommandText& command) {
  std::vector<std::string> names;
  for (const CommandText& child : command.subcommands) names.push_back(child.name);
  for (const OptionText& option : command.options)
    names.insert(names.end(), option.names.begin(), option.names.end());
  return names;
}

std::string bashCompletion(const CommandText& program) {
  std::ostringstream out;
  out << "# bash completion for airclay\n"
         "_airclay() {\n"
         "  local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD-1]} command=\"\" i\n"
         "  for ((i = 1; i < COMP_CWORD; ++i)); do\n"
         "    [[ ${COMP_WORDS[i]} == -* ]] && break\n"
         "    case \"$command ${COMP_WORDS[i]}\" in\n";
  forEachCommand(program, "", [&](const std::string& path, const CommandText& command) {
    out << "      \"" << path << " " << command.name << "\") command=\"" << path << " " << command.name
        << "\" ;;\n";
  });
  out << "      *) break ;;\n    esac\n  done\n  case \"$command|$previous\" in\n";
  forEachCommand(program, "", [&](const std::string& path, const CommandText& command) {
    for (const OptionText& option : command.options)
      if (!option.choices.empty() && !option.positional)
        out << "    \"" << path << " " << command.name << "|" << option.names.back()
            << "\") COMPREPLY=($(compgen -W \"" << joined(option.choices, " ")
            << "\" -- \"$current\")); return ;;\n";
  });
  out << "  esac\n  local words=\"\"\n  case \"$command\" in\n    \"\") words=\""
      << joined(completionsOf(program), " ") << "\" ;;\n";
  forEachCommand(program, "", [&](const std::string& path, const CommandText& command) {
    out << "    \"" << path << " " << command.name << "\") words=\"" << joined(completionsOf(command), " ")
        << "\" ;;\n";
  });
  out << "  esac\n"
         "  if [[ $current == -* || -z $command || ( $words != -* && -n $words ) ]]; then\n"
         "    COMPREPLY=($(compgen -W \"$words\" -- \"$current\"))\n"
         "  fi\n"
         "}\n"
         "complete -o default -o bashdefault -F _airclay airclay\n";
  return out.str();
}

/// Quoted for zsh and fish, where a single quote ends the string.
std::string quoted(const std::string& text, const std::string& escaped_quote) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? escaped_quote : std::string(1, c);
  return out + "'";
}

/// `_arguments` reads [ ] and : itself.
std::string zshText(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '[' || c == ']' || c == ':' || c == '\\') out += '\\';
    out += c;
  }
  return out;
}

std::string zshFunction(const std::string& name) {
  std::string function = "_" + name;
  std::replace(function.begin(), function.end(), ' ', '_');
  return function;
}

void zshCommand(std::ostream& out, const std::string& path, const CommandText& command) {
  out << zshFunction(path) << "() {\n  _arguments -s -S";
  for (const OptionText& option : command.options) {
    if (option.positional) continue;
    const std::string values = option.choices.empty() ? "_files" : "(" + joined(option.choices, " ") + ")";
    for (const std::string& name : option.names)
      out << " \\\n    "
          << quoted("*" + name + "[" + zshText(option.description) + "]" +
                        (option.value.empty() ? "" : ":" + zshText(option.value) + ":" + values),
                    "'\\''");
  }
  if (command.subcommands.empty()) {
    out << " \\\n    '*:file:_files'\n}\n";
    return;
  }
  out << " \\\n    '1:command:((";
  for (const CommandText& child : command.subcommands) {
    std::string description = zshText(child.description);
    std::replace(description.begin(), description.end(), '\'', ' ');
    std::replace(description.begin(), description.end(), '"', ' ');
    out << " " << child.name << "\\:\"" << description << "\"";
  }
  out << " ))' \\\n    '*::argument:->arguments'\n  case $state in arguments)\n    case $words[1] in\n";
  for (const CommandText& child : command.subcommands)
    out << "      " << child.name << ") " << zshFunction(path + " " + child.name) << " ;;\n";
  out << "    esac ;;\n  esac\n}\n";
  for (const CommandText& child : command.subcommands) zshCommand(out, path + " " + child.name, child);
}

std::string zshCompletion(const CommandText& program) {
  std::ostringstream out;
  out << "#compdef airclay\n";
  zshCommand(out, "airclay", program);
  out << "_airclay \"$@\"\n";
  return out.str();
}

std::string fishCompletion(const CommandText& program) {
  std::ostringstream out;
  out << "# fish completion for airclay\n";
  for (const CommandText& command : program.subcommands) {
    out << "complete -c airclay -n __fish_use_subcommand -a " << command.name << " -d "
        << quoted(command.description, "\\'") << "\n";
    const std::string when = "complete -c airclay -n '__fish_seen_subcommand_from " + command.name + "'";
    for (const CommandText& child : command.subcommands)
      out << when << " -a " << child.name << " -d " << quoted(child.description, "\\'") << "\n";
    for (const OptionText& option : command.options) {
      if (option.positional) continue;
      out << when;
      for (const std::string& name : option.names)
        out << (name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1));
      if (!option.value.empty()) out << " -r";
      if (!option.choices.empty()) out << " -f -a " << quoted(joined(option.choices, " "), "\\'");
      out << " -d " << quoted(option.description, "\\'") << "\n";
    }
  }
  return out.str();
}

// ------------------------------------------------------------------------------------------------- markdown

/// A cell of a table: a bar would end it.
std::string cell(std::string text) {
  for (std::size_t at = text.find('|'); at != std::string::npos; at = text.find('|', at + 2))
    text.replace(at, 1, "\\|");
  return text;
}

std::string sentence(std::string text) {
  if (!text.empty()) text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  return text.empty() || text.ends_with('.') ? text : text + '.';
}

/// Help writes a default as "in metres [0.2]" or, among choices, as "right [this], left". Both move to a
/// column.
struct Meaning {
  std::string text, default_value;
};

Meaning meaningOf(const std::string& description) {
  const std::size_t open = description.find(" ["), close = description.find(']', open + 1);
  if (open == std::string::npos || close == std::string::npos) return {description, ""};
  const std::string rest = description.substr(0, open) + description.substr(close + 1);
  std::string value = description.substr(open + 2, close - open - 2);
  if (value == "this") value = description.substr(description.rfind(' ', open - 1) + 1, open - 1);
  if (const std::size_t end = value.find(" ["); end != std::string::npos) value.resize(end);
  return {rest, value};
}

void markdownOptions(std::ostream& out, const CommandText& command) {
  std::ostringstream rows;
  for (const OptionText& option : command.options) {
    if (!option.names.empty() && option.names.back() == "--help") continue;
    const Meaning meaning = meaningOf(option.description);
    std::string value = option.required ? "required" : meaning.default_value;
    rows << "| `" << cell(headOf(option)) << "` | " << cell(value) << " | " << cell(meaning.text) << " |\n";
  }
  if (!rows.str().empty()) out << "\n| option | default | meaning |\n|---|---|---|\n" << rows.str();
}

std::string markdown(const CommandText& program) {
  std::ostringstream out;
  out << "# Commands\n\n"
         "`airclay COMMAND --help` prints the same text. In the source tree, `./airclay COMMAND` builds what "
         "changed, then runs the command.\n"
         "Exit status: 0 success, 1 bad input or a failed comparison, 2 wrong usage, 3 no usable Vulkan "
         "device, 128 + N interrupted by signal N.\n\n"
         "<!-- Generated by `airclay reference markdown`; tests/docs_test.cpp compares the two. -->\n\n"
         "| command | does |\n|---|---|\n";
  const auto anchor = [](std::string name) {
    std::replace(name.begin(), name.end(), ' ', '-');
    return name;
  };
  const auto full_name = [](const std::string& path, const CommandText& command) {  // " rig", "check"
    return (path.empty() ? "" : path.substr(1) + " ") + command.name;
  };
  forEachCommand(program, "", [&](const std::string& path, const CommandText& command) {
    const std::string name = full_name(path, command);
    out << "| [" << name << "](#" << anchor(name) << ") | " << cell(command.description) << " |\n";
  });
  forEachCommand(program, "", [&](const std::string& path, const CommandText& command) {
    out << "\n## " << full_name(path, command) << "\n\n"
        << sentence(command.description) << "\n\n```text\n"
        << usageOf("airclay" + path, command) << "\n```\n";
    markdownOptions(out, command);
    if (!command.notes.empty()) out << "\n" << command.notes;
    if (!command.examples.empty()) out << "\n```sh\n" << command.examples << "```\n";
  });
  return out.str();
}

}  // namespace

void addReference(CLI::App& program, int&) {
  CLI::App& command = *program.add_subcommand("reference", "print the command reference");
  command.group("");
  const auto format = std::make_shared<std::string>();
  command.add_option("format", *format, "man, bash, zsh, fish or markdown")->required();
  command.callback([format, &program] {
    const CommandText text = textOf(program);
    std::string reference;
    if (*format == "man")
      reference = manPage(text);
    else if (*format == "bash")
      reference = bashCompletion(text);
    else if (*format == "zsh")
      reference = zshCompletion(text);
    else if (*format == "fish")
      reference = fishCompletion(text);
    else if (*format == "markdown")
      reference = markdown(text);
    else
      throw Error("reference: no format \"" + *format + "\"; use man, bash, zsh, fish or markdown",
                  Fault::kUsage);
    std::fwrite(reference.data(), 1, reference.size(), stdout);
  });
}

}  // namespace airclay
