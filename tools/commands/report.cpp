// What: `tessera report`: the page of a batch, from what its folder holds.
// Not: its making (batch/write_report.h).
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "kernels/base/errors.h"
#include "kernels/base/parallel.h"
#include "tools/batch/write_report.h"
#include "tools/cli/backend_options.h"
#include "tools/cli/command.h"
#include "tools/cli/terminal.h"

namespace tessera {

void add_report_command(CLI::App& app, Work& work) {
  struct Parsed {
    ReportRequest request;
    int threads = 0;
    bool json = false;
  };
  const auto parsed = std::make_shared<Parsed>();
  CLI::App& command =
      *app.add_subcommand("report", "write the report of a batch: HTML, CSV and JSON");
  command.option_defaults()->always_capture_default();
  command.add_option("out", parsed->request.out, "folder of the batch")->required();
  command.add_option(
      "--pictures", parsed->request.images,
      "held-out views of each scene beside the truth (of each of more than 100 one); "
      "they are drawn once. 0: none");
  add_backend_options(command, parsed->request.backend);
  command.add_option("--threads", parsed->threads, "CPU threads; 0: all");
  command.add_flag("--json", parsed->json, "print what report.json holds");
  command.callback([parsed, &work] {
    work = [parsed] {
      set_thread_count(parsed->threads);
      if (parsed->request.images < 0)
        throw InputError(
            fmt::format("--pictures is {}, expected 0 or more", parsed->request.images));
      const nlohmann::json report = write_report(parsed->request);
      print_result(parsed->json, report,
                   fmt::format("{}: {}", (parsed->request.out / "report" / "index.html").string(),
                               report["summary"].get<std::string>()));
      return int(kExitDone);
    };
  });
}

}  // namespace tessera
