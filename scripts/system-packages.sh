#!/bin/sh
# The system libraries that Qt, VTK and the tests need on Debian and Ubuntu. Fast where nothing is missing.
set -u

missing=""
need() { # need SONAME PACKAGE
  case "$libraries" in *"$1"*) ;; *) missing="$missing $2" ;; esac
}

libraries=$( (ldconfig -p 2>/dev/null || /sbin/ldconfig -p 2>/dev/null) | sed 's/^[[:space:]]*\([^ ]*\).*/\1/')
need libgomp.so.1 libgomp1
need libGL.so.1 libgl1
need libEGL.so.1 libegl1
need libglib-2.0.so.0 libglib2.0-0
need libfontconfig.so.1 libfontconfig1
need libdbus-1.so.3 libdbus-1-3
need libxkbcommon.so.0 libxkbcommon0
need libxcb-cursor.so.0 libxcb-cursor0
need libxcb-icccm.so.4 libxcb-icccm4
need libxcb-keysyms.so.1 libxcb-keysyms1
need libxcb-shape.so.0 libxcb-shape0
need libxcb-xkb.so.1 libxcb-xkb1
need libxkbcommon-x11.so.0 libxkbcommon-x11-0
command -v Xvfb >/dev/null 2>&1 || missing="$missing xvfb"
command -v xauth >/dev/null 2>&1 || missing="$missing xauth"
fc-list 2>/dev/null | grep -q . || [ -d /usr/share/fonts/truetype ] || missing="$missing fonts-dejavu-core"
[ -z "$missing" ] && exit 0

if ! command -v apt-get >/dev/null 2>&1; then
  echo "Concord's window needs these libraries (by their Debian names); install them with your system's tool:$missing" >&2
  exit 2
fi
if [ "$(id -u)" != 0 ]; then
  echo "Concord's window needs system libraries that are missing here. Run this once, then try again:" >&2
  echo "  sudo apt-get install --no-install-recommends$missing" >&2
  exit 2
fi
echo "Installing system libraries:$missing"
apt-get update -qq
case "$missing" in
  *libglib2.0-0*)
    if apt-cache show libglib2.0-0t64 >/dev/null 2>&1; then
      missing=$(printf '%s' "$missing" | sed 's/libglib2.0-0/libglib2.0-0t64/')
    fi ;;
esac
# shellcheck disable=SC2086 # the names are separate words
DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $missing >/dev/null
