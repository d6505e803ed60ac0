// What: one line that says what is wrong with a command line, with the nearest known name.
// Not: --help, which CLI11 writes.
#pragma once
#include <CLI/CLI.hpp>
#include <string>

namespace tessera {

/// After `app` failed to parse.
std::string usage_message(const CLI::App& app, const CLI::ParseError& error);

}  // namespace tessera
