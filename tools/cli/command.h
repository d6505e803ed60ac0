// The interface between main() and the commands: each command has a function that adds it to the
// parser and stores the work to do, which returns an exit code.
#pragma once
#include <CLI/CLI.hpp>
#include <functional>
#include <string>

#include "tools/cli/interrupt.h"

namespace tessera {

/// Adds one subcommand to `app`; its callback stores the work to do in `work`.
using Work = std::function<int()>;

void add_run_command(CLI::App& app, Work& work);
void add_ingest_command(CLI::App& app, Work& work);
void add_unpack_command(CLI::App& app, Work& work);
void add_doctor_command(CLI::App& app, Work& work);
void add_train_command(CLI::App& app, Work& work);
void add_evaluate_command(CLI::App& app, Work& work);
void add_render_command(CLI::App& app, Work& work);
void add_export_command(CLI::App& app, Work& work);
void add_info_command(CLI::App& app, Work& work);
void add_bench_command(CLI::App& app, Work& work);
void add_synth_command(CLI::App& app, Work& work);
void add_batch_command(CLI::App& app, Work& work);
void add_job_command(CLI::App& app, Work& work);
void add_report_command(CLI::App& app, Work& work);
void add_view_command(CLI::App& app, Work& work);
void add_env_command(CLI::App& app, Work& work);
void add_reference_command(CLI::App& app, Work& work);
void add_help_commands(CLI::App& app, Work& work);

}  // namespace tessera
