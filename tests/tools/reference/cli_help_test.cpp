// Help, reference pages, man pages and completion made from the option table.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "ingest/files/atomic_file.h"
#include "recon4d/options/presets.h"
#include "recon4d/options/train_options.h"
#include "tests/tools/commands/cli_workspace.h"

namespace tessera::testing {
namespace {

using nlohmann::json;

std::string output(const CliWorkspace& work, const std::vector<std::string>& arguments) {
  const ChildResult result = work.run(arguments);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  return result.out;
}

std::string dashed(std::string key) {
  std::replace(key.begin(), key.end(), '_', '-');
  return "--" + key;
}

/// The entry of an option in help: its line and those below that are indented more.
std::string entry_of(const std::string& help, const std::string& name) {
  std::istringstream lines(help);
  std::string line, entry;
  while (std::getline(lines, line)) {
    const bool begins = line.starts_with("  -");
    if (!entry.empty() && (begins || line.empty())) return entry;
    const bool is_it = (line + " ").find(" " + name + " ") != std::string::npos ||
                       line.find(" " + name + ",") != std::string::npos;
    if ((begins && is_it) || !entry.empty()) entry += line + "\n";
  }
  return entry;
}

// Bugs put back: all options in --help; no defaults; each seen to fail.
TEST(CliHelp, FitsAScreenAndShowsDefaults) {
  const CliWorkspace work;
  for (const char* command : {"run", "train", "batch"}) {
    const std::string help = output(work, {command, "--help"});
    EXPECT_LE(std::count(help.begin(), help.end(), '\n'), 45) << help;
    EXPECT_NE(help.find("\nExamples:\n  tessera " + std::string(command)), std::string::npos);
    EXPECT_NE(help.find(fmt::format("more options: tessera {} --help-all", command)),
              std::string::npos);
  }
  const std::string help = output(work, {"train", "--help"}),
                    all = output(work, {"train", "--help-all"});
  for (const TrainOption& row : train_option_table()) {
    const std::string entry = entry_of(all, dashed(row.key));
    EXPECT_NE(entry.find(']', entry.find('[')), std::string::npos) << row.key << "\n" << entry;
  }
  EXPECT_NE(entry_of(help, "--iterations").find("[7000]"), std::string::npos) << help;
  EXPECT_NE(entry_of(all, "--iterations").find("7000; fast 2000"), std::string::npos) << all;
  EXPECT_NE(entry_of(all, "--exposure").find("rigs auto"), std::string::npos) << all;
}

// Bugs put back: --no-x sets x; "--x false" leaves false as an argument; each seen to fail.
TEST(CliHelp, SwitchesInEverySpelling) {
  const CliWorkspace work;
  const auto carve = [&](const std::string& run, const std::vector<std::string>& words) {
    const ChildResult result = work.train(run, words);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return json::parse(read_text_file(work / (run + "/config.json")))["options"]["carve"]
        .get<bool>();
  };
  EXPECT_TRUE(carve("a", {"--iterations", "1", "--carve"}));
  EXPECT_FALSE(carve("b", {"--iterations", "1", "--no-carve"}));
  EXPECT_FALSE(carve("c", {"--iterations", "1", "--carve=false"}));
  EXPECT_FALSE(carve("d", {"--iterations", "1", "--carve", "false"}));
}

TEST(CliHelp, SuffixesAndUnderscores) {
  const CliWorkspace work;
  const ChildResult result =
      work.train("run", {"--iterations", "1", "--max_gaussians", "1.5k", "--init-points", "0.1k"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const json options = json::parse(read_text_file(work / "run/config.json"))["options"];
  EXPECT_EQ(options["max_gaussians"], 1500);
  EXPECT_EQ(options["init_points"], 100);
  work.expect_refused({"train", work.at("capture"), "-o", work.at("x"), "--max-bytes", "5TB"},
                      {"max_bytes", "5TB", "5MB"});
}

// Bugs put back: an unreadable switch ends the program by a signal; presets compared with case;
// "25%" refused; each seen to fail.
TEST(CliHelp, ValuesAsPeopleTypeThem) {
  const CliWorkspace work;
  work.expect_refused({"train", work.at("capture"), "-o", work.at("x"), "--deterministic=maybe"},
                      {"--deterministic is 'maybe'", "true or false"});
  const ChildResult result =
      work.train("run", {"--iterations", "1", "--preset", "FAST", "--validation-share", "50%"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const json config = json::parse(read_text_file(work / "run/config.json"));
  EXPECT_EQ(config["preset"], "fast");
  EXPECT_EQ(config["options"]["validation_share"], 0.5);
}

TEST(CliHelp, ReferenceStatesEveryOption) {
  const CliWorkspace work;
  const json reference = json::parse(output(work, {"reference", "json"}));
  EXPECT_EQ(reference["train_options"].size(), train_option_table().size());
  for (const json& row : reference["train_options"])
    EXPECT_TRUE(row["defaults"].contains("balanced")) << row;
  json names;
  for (const Preset& preset : presets()) names.push_back(preset.name);
  EXPECT_NE(reference.dump().find("\"choices\":" + names.dump()), std::string::npos);
}

// Bugs put back: a stale page of a command; a command missing in mkdocs.yml; each seen to fail.
TEST(CliHelp, PagesAreThoseOfTheProgram) {
  const CliWorkspace work;
  const std::filesystem::path source = TESSERA_SOURCE_DIR, folder = source / "docs/reference";
  output(work, {"reference", "markdown", work.at("pages")});
  const std::string site = read_text_file(source / "mkdocs.yml");
  for (const auto& made : std::filesystem::recursive_directory_iterator(work / "pages")) {
    if (made.is_directory()) continue;
    const std::string page = made.path().lexically_relative(work / "pages");
    EXPECT_EQ(read_text_file(made), read_text_file(folder / page))
        << "run `tessera reference markdown docs/reference`";
    EXPECT_NE(site.find(": reference/" + page + "\n"), std::string::npos) << page;
  }
  for (const auto& page : std::filesystem::directory_iterator(folder / "commands"))
    EXPECT_TRUE(exists(work / "pages/commands" / page.path().filename())) << page << " is stale";
}

// Bug put back: dashes not escaped; seen to fail in groff's check.
TEST(CliHelp, ManPages) {
  const CliWorkspace work;
  output(work, {"reference", "man", work.at("man")});
  EXPECT_NE(read_text_file(work / "man/tessera.1").find("tessera\\-train"), std::string::npos);
  const std::string page = work.at("man/tessera-train.1");
  EXPECT_NE(read_text_file(page).find("\\-\\-max\\-gaussians"), std::string::npos);
  if (std::system("command -v groff >/dev/null 2>&1") != 0)
    GTEST_SKIP() << "groff is not installed";
  const std::string check =
      fmt::format("groff -man -Tutf8 -ww -z {} > {} 2>&1", page, work.at("said"));
  EXPECT_EQ(std::system(check.c_str()), 0);
  EXPECT_EQ(read_text_file(work / "said"), "");
}

/// The completions of bash for the last word of `line`.
std::string completed(const CliWorkspace& work, const std::string& words, int word) {
  work.write("complete.sh", fmt::format("source {}\nCOMP_WORDS=({})\nCOMP_CWORD={}\n_tessera\n"
                                        "echo \"${{COMPREPLY[*]}}\"\n",
                                        work.at("tessera.bash"), words, word));
  const std::string command =
      fmt::format("bash {} > {}", work.at("complete.sh"), work.at("completed"));
  EXPECT_EQ(std::system(command.c_str()), 0);
  return read_text_file(work / "completed");
}

// Bug put back: choices of an option not offered; seen to fail.
TEST(CliHelp, BashCompletes) {
  const CliWorkspace work;
  work.write("tessera.bash", output(work, {"reference", "bash"}));
  EXPECT_EQ(completed(work, "tessera tr", 1), "train\n");
  EXPECT_EQ(completed(work, "tessera train --pre", 2), "--preset\n");
  EXPECT_EQ(completed(work, "tessera train --preset fa", 3), "fast faster-gs\n");
  EXPECT_EQ(completed(work, "tessera train --motion v", 3), "velocity\n");
  EXPECT_EQ(completed(work, "tessera train --no-ca", 2), "--no-carve\n");
}

TEST(CliHelp, OtherShellsAcceptTheirScripts) {
  const CliWorkspace work;
  work.write("_tessera", output(work, {"reference", "zsh"}));
  work.write("tessera.fish", output(work, {"reference", "fish"}));
  EXPECT_NE(read_text_file(work / "_tessera").find("#compdef tessera"), std::string::npos);
  EXPECT_NE(read_text_file(work / "tessera.fish").find("-l preset"), std::string::npos);
  bool any = false;
  const std::pair<const char*, std::string> checks[] = {
      {"zsh", "zsh -n " + work.at("_tessera")}, {"fish", "fish -n " + work.at("tessera.fish")}};
  for (const auto& [shell, check] : checks) {
    if (std::system(fmt::format("command -v {} >/dev/null 2>&1", shell).c_str()) != 0) continue;
    any = true;
    EXPECT_EQ(std::system(check.c_str()), 0) << shell;
  }
  if (!any) GTEST_SKIP() << "neither zsh nor fish is installed; the texts alone were checked";
}

TEST(CliHelp, EnvStatesVersionAndDevices) {
  const CliWorkspace work;
  const json facts = work.run_json({"env"});
  for (const char* key : {"version", "commit", "compiler", "build", "system", "cpu", "threads",
                          "memory_gib", "cuda", "player_page", "libraries", "programs"})
    EXPECT_TRUE(facts.contains(key)) << key;
  const std::string text = output(work, {"env"});
  EXPECT_TRUE(text.starts_with("tessera")) << text;
  EXPECT_NE(text.find("backend"), std::string::npos);
}

}  // namespace
}  // namespace tessera::testing
