// Style and script are files of this folder, which the assembler reads into the program.
#include "tools/report/page_frame.h"

#include <fmt/format.h>

#include <string_view>

#include "tools/player/page_words.h"

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
