// Embeds the page that the build made, by the assembler.
#include "tools/player/player_page.h"

#include "kernels/base/errors.h"

asm(R"(
.pushsection .rodata
.global tessera_player_page_begin
.global tessera_player_page_end
tessera_player_page_begin:
.incbin ")" TESSERA_PLAYER_PAGE R"("
tessera_player_page_end:
.byte 0
.popsection
)");

extern "C" const char tessera_player_page_begin[];
extern "C" const char tessera_player_page_end[];

namespace tessera {

namespace {

size_t page_bytes() {
  return size_t(tessera_player_page_end - tessera_player_page_begin);
}

}  // namespace

bool carries_player_page() {
  return page_bytes() > 0;
}

std::string_view player_page() {
  if (!carries_player_page())
    throw InputError(
        "this build has no player page: npm could not fetch its packages; build again with a "
        "network");
  return {tessera_player_page_begin, page_bytes()};
}

}  // namespace tessera
