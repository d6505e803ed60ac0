// What: leaks that LeakSanitizer finds in libraries and does not report. Linked into sanitized tests.
// Not: anything of ours.
// Source: the encoder of test videos: libx265's frame threads end with buffers of theirs in hand.

extern "C" const char* __lsan_default_suppressions() { return "leak:libx265\n"; }
