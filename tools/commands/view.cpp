// `tessera view` serves a running training, or the player of a finished run, an export or a model,
// to a browser. tools/view has the server.
#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <system_error>
#include <thread>

#include "ingest/files/folders.h"
#include "ingest/files/json_file.h"
#include "static3d/transform/world_change.h"
#include "tools/cli/command.h"
#include "tools/cli/interrupt.h"
#include "tools/cli/terminal.h"
#include "tools/clip/clip.h"
#include "tools/export/formats.h"
#include "tools/export/player_files.h"
#include "tools/live/live_watch.h"
#include "tools/live/open_browser.h"
#include "tools/live/stopped_training.h"
#include "tools/session/locks.h"
#include "tools/session/run_folder.h"
#include "tools/session/version.h"
#include "tools/session/windows_folder.h"
#include "tools/view/view_request.h"
#include "tools/view/view_server.h"
#include "tools/web/page_words.h"
#include "tools/web/web_page.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

struct ViewSource {
  std::filesystem::path folder;  // to serve
  std::string start = "/";       // the page in it, as a path of the server
  /// finished: the page that a run or an export wrote; model; or training: `run` is its folder.
  std::string kind;
  std::filesystem::path run;
  std::unique_ptr<TemporaryFolder> temporary;  // that holds `folder` where the page was made
};

/// Of the folders in which commands leave pages, in this order: run and export, run, batch.
constexpr const char* kPagePlaces[] = {"", "player", "report"};

/// Of a model, or of the windows of a clip.
ViewSource made_page(const std::string& path) {
  ViewSource source;
  source.kind = "model";
  source.temporary = std::make_unique<TemporaryFolder>("view");
  source.folder = source.temporary->path() / "page";
  ExportRequest page;
  page.model = path;
  page.out = source.folder.string();
  page.format = "page";
  Clip clip = load_clip(path);
  for (const std::string& warning : clip.warnings) warn(warning);
  clip.edit([](GaussianModel& model) { model = model_in_source_world(model); });
  find_time_format(page.format)->write(page, clip);
  return source;
}

/// The run folder in `path` that a training writes now, of a clip in windows that of the window;
/// "": none.
fs::path training_in(const fs::path& path) {
  std::vector<fs::path> runs;
  const WindowsFolder windows = windows_folder_of(path);
  if (windows.exists()) {
    runs.push_back(windows.static_run());
    std::error_code none;
    for (const auto& run : fs::directory_iterator(windows.root / "windows", none))
      runs.push_back(run.path());
  } else {
    runs.push_back(run_folder_of(path));
  }
  const auto found = std::find_if(runs.begin(), runs.end(), is_run_locked);
  return found != runs.end() ? *found : fs::path();
}

/// `path`: an OUT of `tessera run` or a run folder that a training writes now, an OUT of `tessera
/// run` or `tessera batch`, a folder with an index.html, or what
/// `tessera export` takes: the page of that model is made in a temporary folder. Errors: InputError
/// naming the path and what is accepted.
ViewSource view_source(const std::string& path) {
  if (const fs::path run = training_in(path); !run.empty()) {
    ViewSource source;
    source.folder = path;
    source.start = "/live";
    source.kind = "training";
    source.run = run;
    return source;
  }
  for (const fs::path place : kPagePlaces) {
    if (!fs::is_regular_file(path / place / kPageFile)) continue;
    ViewSource source;
    source.folder = path;
    source.start = place.empty() ? "/" : "/" + place.string() + "/";
    source.kind = "finished";
    return source;
  }
  return made_page(path);
}

struct ViewArguments {
  std::string path, host = "127.0.0.1";
  int port = 0;
  std::vector<std::string> allowed_hosts;
  bool no_browser = false, json = false;
  std::string resumed_by;  // a command; "": no training has this view for its own
};

bool is_set(const char* variable) {
  const char* const value = std::getenv(variable);
  return value != nullptr && *value != '\0';
}

OpenFile opened_folder(const std::filesystem::path& folder) {
  OpenFile opened(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!opened.is_open())
    throw std::filesystem::filesystem_error("open", folder,
                                            std::error_code(errno, std::system_category()));
  return opened;
}

/// What stands for this server in addresses and in Host headers; IPv6 addresses in brackets.
std::string address_host(const ViewArguments& arguments, const ListeningSocket& socket) {
  if (socket.is_any) return host_name();
  return socket.is_ipv6 && arguments.host.find(':') != std::string::npos
             ? "[" + arguments.host + "]"
             : arguments.host;
}

/// The command for the machine of the user, who has logged in here. SSH_CONNECTION has the address
/// by which that machine reaches this one as its third word.
std::string tunnel_command(const ListeningSocket& socket) {
  std::istringstream words(std::getenv("SSH_CONNECTION"));
  std::string client, client_port, server;
  words >> client >> client_port >> server;
  const char* const user = std::getenv("USER");
  return fmt::format(
      "ssh -L {0}:{1}:{0} {2}{3}", socket.port, socket.is_ipv6 ? "[::1]" : "127.0.0.1",
      user != nullptr ? fmt::format("{}@", user) : "", server.empty() ? host_name() : server);
}

void print_address(const ViewArguments& arguments, const ListeningSocket& socket,
                   const std::string& kind, const std::string& address) {
  print_result(arguments.json, {{"url", address}, {"port", socket.port}, {"path", arguments.path}},
               address);
  std::fflush(stdout);  // a program that reads the address waits for it
  if (!socket.is_loopback)
    warn(
        fmt::format("view: --host {} sends the token and all files as plain HTTP, which others in "
                    "the network can read; 127.0.0.1 with `ssh -L` is encrypted",
                    arguments.host));
  if (is_set("SSH_CONNECTION") && socket.is_loopback)
    say(fmt::format("view: on your own machine run `{}`, then open the address there",
                    tunnel_command(socket)));
  if (arguments.resumed_by.empty())
    say(fmt::format("view: Ctrl-C ends the view{}",
                    kind == "training" ? "; the training continues" : ""));
}

/// Whether nobody reads what this process prints: the training that has this view has ended.
bool has_no_reader() {
  pollfd out{STDOUT_FILENO, 0, 0};
  return ::poll(&out, 1, 0) > 0 && (out.revents & POLLERR) != 0;
}

/// The pages and answers of a training that is watched.
void watch_training(LiveWatch& watch, ViewState& state) {
  state.live_page = report_page();
  std::string data(kReportData);
  fill_place(data, "null", "\"live\"");
  fill_place(state.live_page, kReportData, data);
  state.player_page = page_of_folder({});
  state.live = LiveHooks{
      [&watch](int64_t seen) { return watch.state(seen); }, [&watch] { return watch.report(); },
      [&watch](int64_t view) { return watch.truth(view); }, [&watch] { return watch.stop(); }};
}

constexpr std::chrono::milliseconds kPoll{50}, kLonger{3000};

int view(const ViewArguments& arguments) {
  require_view_server();
  ListeningSocket socket = listen_on(arguments.host, uint16_t(arguments.port));
  const ViewSource source = view_source(arguments.path);
  ViewState state;
  state.folder = opened_folder(source.folder);
  state.token = make_view_token();
  state.allowed_hosts = arguments.allowed_hosts;
  const std::string host = address_host(arguments, socket);
  state.allowed_hosts.push_back(host);
  state.start = source.start;
  std::unique_ptr<LiveWatch> watch;  // outlives the server, which calls it
  if (source.kind == "training") {
    watch = std::make_unique<LiveWatch>(source.run, source.folder, arguments.resumed_by);
    watch_training(*watch, state);
  }
  state.run = json_text(
      nlohmann::json{{"kind", source.kind}, {"path", arguments.path}, {"version", kVersionText}});
  const std::string address = fmt::format("http://{}:{}/?token={}", host, socket.port, state.token);
  print_address(arguments, socket, source.kind, address);
  if (source.kind != "training")
    if (const std::string stopped = stopped_line(arguments.path); !stopped.empty())
      say(fmt::format("view: {}: {}", arguments.path, stopped));
  const bool has_desktop =
      (is_set("DISPLAY") || is_set("WAYLAND_DISPLAY")) && !is_set("SSH_CONNECTION");
  const ViewServer server(std::move(state), std::move(socket));
  std::optional<TemporaryFolder> leading;  // until the end: a browser may be slow to begin
  if (has_desktop && !arguments.no_browser)
    open_browser(leading_page(leading.emplace("view").path(), address));
  const bool is_owned = !arguments.resumed_by.empty();
  while (!interrupted() && !(is_owned && has_no_reader())) std::this_thread::sleep_for(kPoll);
  // the page that has stopped the training asks once a second
  for (auto left = kLonger; watch && watch->owes_resume() && left > kPoll; left -= kPoll)
    std::this_thread::sleep_for(kPoll);
  return kExitDone;
}

}  // namespace

void add_view_command(CLI::App& app, Work& work) {
  const auto arguments = std::make_shared<ViewArguments>();
  CLI::App& command = *app.add_subcommand(
      "view", "show a training while it runs, or serve the player of a run, an export or a model");
  command.option_defaults()->always_capture_default();
  command
      .add_option("path", arguments->path,
                  "output of `tessera run` or run folder, also of a training that runs now; "
                  "exported player, or what `tessera export` reads: run "
                  "folder, folder of windows, checkpoint, .ply, 4D file")
      ->required();
  command.add_option("--port", arguments->port, "port to listen on; 0: a free one")
      ->check(CLI::Range(0, 65535));
  command.add_option("--host", arguments->host,
                     "address to listen on; other machines reach 127.0.0.1 through `ssh -L` only");
  command.add_option("--allow-host", arguments->allowed_hosts,
                     "a further name by which browsers may call this machine, such as that of a "
                     "proxy");
  command.add_flag("--no-browser", arguments->no_browser, "print the address only");
  command.add_flag("--json", arguments->json, "print the address as a JSON object");
  command
      .add_option("--resumed-by", arguments->resumed_by,
                  "of a training with --view: the command that resumes it; the training reads the "
                  "address from stdout")
      ->group("");
  command.callback([arguments, &work] { work = [arguments] { return view(*arguments); }; });
}

}  // namespace tessera
