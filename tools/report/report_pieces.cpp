// Formats numbers and images, and embeds style and script of this folder by the assembler.
#include "tools/report/report_pieces.h"

#include <fmt/format.h>

#include <cmath>
#include <string_view>

#include "tools/web/page_words.h"

#define TESSERA_PAGE_FILE(name, path) \
  asm(".pushsection .rodata\n"        \
      ".global tessera_report_" #name \
      "\n"                            \
      "tessera_report_" #name         \
      ":\n"                           \
      ".incbin \"" path               \
      "\"\n"                          \
      ".byte 0\n"                     \
      ".popsection\n");               \
  extern "C" const char tessera_report_##name[]
TESSERA_PAGE_FILE(css, TESSERA_REPORT_CSS);
TESSERA_PAGE_FILE(js, TESSERA_REPORT_JS);
#undef TESSERA_PAGE_FILE

namespace tessera {

std::string time_words(double seconds) {
  if (seconds < 60) return fmt::format("{:.1f} s", seconds);
  const int64_t whole = std::llround(seconds);
  if (whole < 3600) return fmt::format("{}:{:02} min", whole / 60, whole % 60);
  return fmt::format("{}:{:02}:{:02} h", whole / 3600, whole / 60 % 60, whole % 60);
}

std::string size_words(int64_t bytes) {
  if (bytes < 1000) return fmt::format("{} B", bytes);
  if (bytes < 1'000'000) return fmt::format("{:.1f} kB", double(bytes) / 1e3);
  if (bytes < 1'000'000'000) return fmt::format("{:.1f} MB", double(bytes) / 1e6);
  return fmt::format("{:.2f} GB", double(bytes) / 1e9);
}

std::string fact_html(const std::string& name, const std::string& html) {
  if (html.empty()) return "";
  return fmt::format("<dt>{}</dt><dd>{}</dd>\n", html_text(name), html);
}

std::string fact(const std::string& name, const std::string& value) {
  return fact_html(name, html_text(value));
}

std::string report_frame(const std::string& title, const std::string& body) {
  return fmt::format(
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta name=\"color-scheme\" content=\"light dark\">\n<title>{}</title>\n"
      "<style>\n{}</style>\n</head>\n<body>\n<main>\n{}</main>\n<script>\n{}</script>\n</body>\n"
      "</html>\n",
      html_text(title), std::string_view(tessera_report_css), body,
      std::string_view(tessera_report_js));
}

}  // namespace tessera
