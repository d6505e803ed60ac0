// What: leaks of libraries that LeakSanitizer does not report; linked into sanitized tests.
// Not: anything of ours.
// Source: libx265, which encodes test videos: its frame threads end with buffers in hand.

extern "C" const char* __lsan_default_suppressions() {
  return "leak:libx265\n";
}
