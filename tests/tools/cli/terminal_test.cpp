// The bytes that messages and progress bars write to a terminal, with a pseudo-terminal as stderr.
#include "tools/cli/terminal.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <pty.h>
#include <unistd.h>

#include <algorithm>
#include <thread>
#include <vector>

#include "tools/cli/usage_message.h"

namespace tessera {
namespace {

/// Until it is destroyed, stderr is a terminal of so many columns.
class PseudoTerminal {
 public:
  explicit PseudoTerminal(unsigned short columns) {
    winsize size{};
    size.ws_row = 24;
    size.ws_col = columns;
    int terminal = -1;
    EXPECT_EQ(openpty(&reader_, &terminal, nullptr, nullptr, &size), 0);
    fcntl(reader_, F_SETFL, O_NONBLOCK);
    stderr_ = dup(STDERR_FILENO);
    dup2(terminal, STDERR_FILENO);
    close(terminal);
  }
  PseudoTerminal(const PseudoTerminal&) = delete;
  PseudoTerminal& operator=(const PseudoTerminal&) = delete;
  ~PseudoTerminal() {
    dup2(stderr_, STDERR_FILENO);
    close(stderr_);
    close(reader_);
  }
  /// All that was written since the last call.
  std::string written() {
    std::string text;
    char part[4096];
    for (ssize_t n; (n = read(reader_, part, sizeof part)) > 0;) text.append(part, size_t(n));
    return text;
  }

 private:
  int reader_ = -1, stderr_ = -1;
};

/// The text drawn after each clearing of the line.
std::vector<std::string> redraws(const std::string& text) {
  const std::string clear = "\r\033[K";
  std::vector<std::string> lines;
  for (size_t begin = text.find(clear); begin != std::string::npos;) {
    const size_t next = text.find(clear, begin + 1);
    lines.push_back(text.substr(begin + clear.size(), next - begin - clear.size()));
    begin = next;
  }
  return lines;
}

/// The redraws of a bar that is updated every millisecond for so many seconds.
std::vector<std::string> bar_for(PseudoTerminal& terminal, double seconds) {
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  ProgressBar bar("train");
  std::string written;
  for (int i = 0; std::chrono::duration<double>(Clock::now() - begin).count() < seconds; ++i) {
    bar.update(i, 5000, "loss 0.0123, 1000 static + 200 dynamic, 3.1 steps/s");
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    written += terminal.written();
  }
  return redraws(written);
}

class Terminal : public ::testing::Test {
 protected:
  void SetUp() override {
    unsetenv("NO_COLOR");
    unsetenv("COLUMNS");
    setenv("TERM", "xterm", 1);
  }
  void TearDown() override { set_verbosity(Verbosity::kNormal); }
};

// Bugs put back, each seen to fail: the width is not read; the bar is drawn at every update.
TEST_F(Terminal, TheBarIsOneLineAtMostTenTimesASecond) {
  for (const unsigned short columns : {40, 80, 200}) {
    PseudoTerminal terminal(columns);
    EXPECT_EQ(terminal_columns(), columns);
    const std::vector<std::string> lines = bar_for(terminal, 0.55);
    EXPECT_GE(lines.size(), 2u);
    EXPECT_LE(lines.size(), 5u);
    for (const std::string& line : lines) {
      EXPECT_LT(line.size(), columns) << line;
      EXPECT_EQ(line.find("loss") != std::string::npos, columns == 200) << line;
    }
  }
}

TEST_F(Terminal, ColumnsIsTakenWhereTheTerminalHasNoWidth) {
  PseudoTerminal terminal(0);
  EXPECT_EQ(terminal_columns(), 80);
  setenv("COLUMNS", "50", 1);
  EXPECT_EQ(terminal_columns(), 50);
  setenv("COLUMNS", "wide", 1);
  EXPECT_EQ(terminal_columns(), 80);
}

// Bugs put back, each seen to fail: NO_COLOR is not read; every stderr is coloured.
TEST_F(Terminal, WarningsAreYellowOnATerminalUnlessNoColorIsSet) {
  PseudoTerminal terminal(80);
  warn("low light");
  EXPECT_EQ(terminal.written(), "\033[33mwarning:\033[0m low light\r\n");
  setenv("NO_COLOR", "1", 1);
  warn("low light");
  EXPECT_EQ(terminal.written(), "warning: low light\r\n");
  unsetenv("NO_COLOR");
  ::testing::internal::CaptureStderr();
  warn("low light");
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "warning: low light\n");
}

// Bug put back: say ignores the verbosity; seen to fail.
TEST_F(Terminal, QuietLeavesWarningsAndErrors) {
  set_verbosity(Verbosity::kQuiet);
  PseudoTerminal terminal(80);
  setenv("NO_COLOR", "1", 1);
  EXPECT_TRUE(bar_for(terminal, 0.15).empty());
  say("12 images");
  warn("low light");
  report_error("tessera: failed");
  EXPECT_EQ(terminal.written(), "warning: low light\r\ntessera: failed\r\n");
}

// Bugs put back, each seen to fail: no command has the flags; both at once are taken.
TEST_F(Terminal, EveryCommandHasBothFlags) {
  for (const auto& [flag, expected] : {std::pair{"-q", Verbosity::kQuiet},
                                       {"--quiet", Verbosity::kQuiet},
                                       {"-v", Verbosity::kVerbose},
                                       {"--verbose", Verbosity::kVerbose}})
    for (const char* command : {"train", "render"}) {
      CLI::App app;
      app.add_subcommand("train");
      app.add_subcommand("render");
      add_verbosity(app);
      set_verbosity(Verbosity::kNormal);
      app.parse(std::string(command) + " " + flag);
      EXPECT_EQ(verbosity(), expected) << command << " " << flag;
      EXPECT_THROW(app.parse(std::string(command) + " -q -v"), CLI::ParseError);
    }
}

}  // namespace
}  // namespace tessera
