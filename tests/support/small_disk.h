// A disk of a few pages that fills up: a tmpfs that only this process sees. Where mounts are not
// allowed, `works()` is false.
#pragma once
#include <fcntl.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <string>

namespace tessera::testing {

class SmallDisk {
 public:
  /// Mounts it at `place`, an empty folder, with room for what is to be there before it fills up.
  explicit SmallDisk(const std::filesystem::path& place) : place_(place) {
    works_ = has_own_mounts() && ::mount("tmpfs", place.c_str(), "tmpfs", 0, "size=256m") == 0;
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;
  ~SmallDisk() {
    if (works_) ::umount2(place_.c_str(), MNT_DETACH);
  }

  bool works() const { return works_; }
  /// From now on there is room for so many bytes more, in pages; something must be there, for a
  /// size of 0 is none. False where that cannot be set.
  bool leave(int64_t bytes) const {
    struct statvfs now {};
    if (::statvfs(place_.c_str(), &now) != 0) return false;
    const auto used = int64_t((now.f_blocks - now.f_bfree) * now.f_frsize);
    return used + bytes > 0 && resize(used + bytes);
  }
  bool clear() const { return resize(int64_t{256} << 20); }

 private:
  bool resize(int64_t bytes) const {
    const std::string size = "size=" + std::to_string(bytes);
    return ::mount(nullptr, place_.c_str(), nullptr, MS_REMOUNT, size.c_str()) == 0;
  }

  static bool write_to(const char* file, const std::string& text) {
    const int descriptor = ::open(file, O_WRONLY);
    const bool written = ::write(descriptor, text.data(), text.size()) == ssize_t(text.size());
    ::close(descriptor);
    return written;
  }

  /// Mounts of this process alone: as root, else as the root of a user namespace of its own.
  static bool has_own_mounts() {
    static const bool done = [] {
      const uid_t user = ::getuid();
      const gid_t group = ::getgid();
      if (user != 0 && ::unshare(CLONE_NEWUSER) == 0) {
        write_to("/proc/self/setgroups", "deny");
        write_to("/proc/self/uid_map", "0 " + std::to_string(user) + " 1");
        write_to("/proc/self/gid_map", "0 " + std::to_string(group) + " 1");
      }
      return ::unshare(CLONE_NEWNS) == 0 &&
             ::mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0;
    }();
    return done;
  }

  std::filesystem::path place_;
  bool works_ = false;
};

}  // namespace tessera::testing
