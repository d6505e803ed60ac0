# Sourced by check_fresh.sh and check_package.sh: a root folder made by debootstrap with the packages
# that every Debian has, and, of this machine, only host names and certificates. Needs root.

# make_root SUITE FOLDER WORK   archives of packages are kept below WORK
make_root() {
  local suite=$1 root=$2 work=$3
  mkdir -p "$work/archives"
  unmount_root "$root"
  rm -rf --one-file-system "$root"
  debootstrap --variant=minbase "$suite" "$root" "${DEBIAN_MIRROR:-http://deb.debian.org/debian}" \
    >"$root.debootstrap.log"
  mkdir -p "$root/var/cache/apt/archives" "$root/opt/certificates"
  mount --bind "$work/archives" "$root/var/cache/apt/archives"  # downloads are not what is timed
  mount -t proc proc "$root/proc"
  mount -t sysfs sys "$root/sys" 2>/dev/null || true
  mount --rbind --make-slave /dev "$root/dev" 2>/dev/null || mount --bind /dev "$root/dev"
  cp /etc/resolv.conf /etc/hosts "$root/etc/"
  if [ -f /etc/ssl/certs/ca-certificates.crt ]; then
    cp /etc/ssl/certs/ca-certificates.crt "$root/opt/certificates/"
  fi
}

unmount_root() {
  local point
  for point in proc dev sys var/cache/apt/archives; do
    if mountpoint -q "$1/$point"; then
      umount -R -l "$1/$point"  # lazily: what a killed command left running may still hold it
    fi
  done
}

# in_root FOLDER COMMAND   with nothing of this machine's environment
in_root() {
  env -i HOME=/root PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 \
    NODE_EXTRA_CA_CERTS=/opt/certificates/ca-certificates.crt \
    CURL_CA_BUNDLE=/opt/certificates/ca-certificates.crt chroot "$1" bash -c "$2"
}

packages_in() { in_root "$1" "dpkg-query -W -f='x\n' | wc -l"; }
