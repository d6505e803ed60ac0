// `tessera report` writes the page of a run or of a batch from the files of its folder.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"
#include "tools/batch/write_report.h"
#include "tools/cli/backend_options.h"
#include "tools/cli/command.h"
#include "tools/cli/terminal.h"
#include "tools/report/write_run_report.h"
#include "tools/web/web_page.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

struct ReportArguments {
  ReportRequest batch;
  std::vector<fs::path> folders;
  fs::path out;
  int threads = 0;
  bool json = false, no_images = false, overwrite = false;
};

void say_without_pages() {
  if (!carries_pages())
    report_error("tessera: this build has no web pages: the report has data and images alone");
}

void report_of_runs(const ReportArguments& arguments) {
  if (arguments.folders.size() > 1 && arguments.out.empty())
    throw InputError("-o is missing: the folder for the report that compares these runs");
  const nlohmann::json report = write_run_report(
      {arguments.folders, arguments.out, [&] { return make_backend(arguments.batch.backend); },
       arguments.overwrite});
  say_without_pages();
  print_result(arguments.json, report, report["page"].get<std::string>());
}

void report_of_batch(const ReportArguments& arguments) {
  if (!arguments.out.empty())
    throw InputError("-o is for the report of a run; that of a batch is written to report/ in it");
  const nlohmann::json report = write_report(arguments.batch);
  say_without_pages();
  const char* const file = carries_pages() ? "index.html" : "report.json";
  print_result(arguments.json, report,
               fmt::format("{}: {}", (arguments.batch.out / "report" / file).string(),
                           report["batch"]["summary"].get<std::string>()));
}

}  // namespace

void add_report_command(CLI::App& app, Work& work) {
  const auto parsed = std::make_shared<ReportArguments>();
  CLI::App& command = *app.add_subcommand(
      "report", "write the report of a run, of several to compare, or of a batch: a page and data");
  command.option_defaults()->always_capture_default();
  command
      .add_option("folder", parsed->folders,
                  "output folders of `tessera run` or run folders, or the folder of one batch")
      ->required();
  command.add_option("-o,--out", parsed->out,
                     "folder for the report of runs; default, of one run: report/ in it");
  command.add_flag("--overwrite", parsed->overwrite, "write among files that are not ours");
  command.add_flag("--no-images", parsed->no_images,
                   "batch: without views of its runs, which are rendered once for each scene and "
                   "preset");
  add_backend_options(command, parsed->batch.backend);
  command.add_option("--threads", parsed->threads, "CPU threads; 0: all");
  command.add_flag("--json", parsed->json, "print what report.json holds");
  command.callback([parsed, &work] {
    work = [parsed] {
      set_thread_count(parsed->threads);
      parsed->batch.out = parsed->folders.front();
      parsed->batch.images = !parsed->no_images;
      const bool of_runs = parsed->folders.size() > 1 || is_run(parsed->batch.out);
      of_runs ? report_of_runs(*parsed) : report_of_batch(*parsed);
      return int(kExitDone);
    };
  });
}

}  // namespace tessera
