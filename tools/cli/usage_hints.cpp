// What: the two tables.
// Not: the message around the advice (usage_message.cpp).
#include "tools/cli/usage_hints.h"

namespace tessera {
namespace {

struct Advice {
  const char *command, *typed, *text;
};
constexpr Advice kAdvice[] = {
    {"run", "--resume", "run resumes by itself: repeat the command"},
    {"ingest", "--resume", "finished scenes of a folder are kept: repeat the command"},
    {"batch", "--resume", "batch resumes by itself: repeat the command"},
    {"bench", "--resume", "finished runs are kept: repeat the command"},
};

struct OtherName {
  const char *typed, *ours;
};
constexpr OtherName kOtherNames[] = {
    {"-p", "--preset"},           {"-j", "--threads"},           {"--jobs", "--threads"},
    {"--device", "--backend"},    {"--output", "--out"},         {"--output-dir", "--out"},
    {"--force", "--overwrite"},   {"--steps", "--iterations"},   {"--max-steps", "--iterations"},
    {"--epochs", "--iterations"}, {"--load-config", "--config"},
};

}  // namespace

std::string usage_advice(const std::string& command, const std::string& typed) {
  for (const Advice& row : kAdvice)
    if (command == row.command && typed == row.typed) return row.text;
  return "";
}

std::string our_option_name(const std::string& typed) {
  for (const OtherName& row : kOtherNames)
    if (typed == row.typed) return row.ours;
  return "";
}

}  // namespace tessera
