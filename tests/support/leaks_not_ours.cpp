// Suppressions of LeakSanitizer for libraries, linked into sanitized tests. Source: libx265, which
// encodes test videos and whose frame threads end without freeing their buffers.

extern "C" const char* __lsan_default_suppressions() {
  return "leak:libx265\n";
}
