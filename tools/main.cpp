// The `tessera` program: selects the command and converts errors into exit codes.
#include <fmt/format.h>
#include <malloc.h>

#include <algorithm>

#include "ingest/files/atomic_file.h"
#include "ingest/prepared/scene_clip.h"
#include "kernels/base/errors.h"
#include "tools/cli/argument_words.h"
#include "tools/cli/command.h"
#include "tools/cli/interrupt.h"
#include "tools/cli/option_help.h"
#include "tools/cli/terminal.h"
#include "tools/cli/usage_message.h"
#include "tools/session/version.h"

namespace tessera {
namespace {

/// Names out of files may have line ends.
std::string one_line(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
  return text;
}

int run_command(const Work& work) {
  try {
    return work();
  } catch (const InputError& error) {
    report_error(fmt::format("tessera: {}", one_line(error.what())));
    return kExitBadInput;
  } catch (const std::filesystem::filesystem_error& error) {
    report_error(
        fmt::format("tessera: {}: cannot be reached ({}); check this path and its permissions",
                    error.path1().string(), error.code().message()));
    return path_is_at_fault(error.code().value()) ? kExitBadInput : kExitFailed;
  } catch (const Interrupted&) {
    report_error("tessera: interrupted; no partial output was written");
    return stop_code();
  } catch (const std::bad_alloc&) {
    report_error(
        "tessera: out of memory; try a smaller --scale, fewer --init-points or --max-gaussians");
    return kExitFailed;
  } catch (const std::exception& error) {
    report_error(fmt::format("tessera: {}", one_line(error.what())));
    return kExitFailed;
  }
}

/// Images of some megabytes come and go on all threads: where each goes back to the system, new
/// pages for the next cost up to a third of the time that is spent on it.
void keep_freed_memory() {
  mallopt(M_MMAP_THRESHOLD, 32 << 20);
  mallopt(M_TRIM_THRESHOLD, 64 << 20);
}

int tessera_main(int argc, char** argv) {
  keep_freed_memory();
  install_interrupt_handlers();
  CLI::App app("Tessera turns multi-view video into 4D Gaussians that play.", "tessera");
  app.formatter(help_formatter());
  app.set_help_flag("-h,--help", "show the options that are used often");
  app.set_help_all_flag("--help-all", "show all options");
  app.set_version_flag("-V,--version", kVersionText, "print the version");
  app.require_subcommand(1);
  Work work;
  add_run_command(app, work);
  set_clip_reader(video_clip_reader());
  add_ingest_command(app, work);
  add_unpack_command(app, work);
  add_doctor_command(app, work);
  add_train_command(app, work);
  add_evaluate_command(app, work);
  add_render_command(app, work);
  add_export_command(app, work);
  add_info_command(app, work);
  add_bench_command(app, work);
  add_synth_command(app, work);
  add_batch_command(app, work);
  add_job_command(app, work);
  add_report_command(app, work);
  add_view_command(app, work);
  add_env_command(app, work);
  add_reference_command(app, work);
  add_help_commands(app, work);
  add_verbosity(app);
  accept_suffixes(app);
  const std::vector<std::string> words(argv + 1, argv + argc);
  if (const std::string complaint = switch_complaint(words); !complaint.empty()) {
    report_error(fmt::format("tessera: {}", complaint));
    return kExitBadInput;
  }
  try {
    app.parse(joined_switches(words));
  } catch (const CLI::ParseError& error) {
    const bool is_request = error.get_exit_code() == 0;  // --help, --version
    if (is_request && !names_no_command(app)) return app.exit(error);
    report_error(usage_message(app, error));
    return kExitBadInput;
  }
  return run_command(work);
}

}  // namespace
}  // namespace tessera

int main(int argc, char** argv) {
  return tessera::tessera_main(argc, argv);
}
