// Embeds the pages that the build made, by the assembler.
#include "tools/web/web_page.h"

#include "kernels/base/errors.h"

asm(R"(
.pushsection .rodata
.global tessera_player_page_begin
.global tessera_report_page_begin
.global tessera_pages_end
tessera_player_page_begin:
.incbin ")" TESSERA_PAGE_FOLDER R"(/player.html"
tessera_report_page_begin:
.incbin ")" TESSERA_PAGE_FOLDER R"(/report.html"
tessera_pages_end:
.byte 0
.popsection
)");

extern "C" const char tessera_player_page_begin[];
extern "C" const char tessera_report_page_begin[];
extern "C" const char tessera_pages_end[];

namespace tessera {

namespace {

std::string_view page(const char* begin, const char* end) {
  if (!carries_pages())
    throw InputError(
        "this build has no web pages: their packages could not be fetched; build again with a "
        "network");
  return {begin, size_t(end - begin)};
}

}  // namespace

bool carries_pages() {
  return tessera_pages_end - tessera_player_page_begin > 0;
}

std::string_view player_page() {
  return page(tessera_player_page_begin, tessera_report_page_begin);
}

std::string_view report_page() {
  return page(tessera_report_page_begin, tessera_pages_end);
}

}  // namespace tessera
