#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Installs the packages of packages.txt that this machine lacks. Usage: setup.sh FOLDER, where a note is left of
# the package database that was seen complete, so that the next call costs nothing.
set -euo pipefail

here=$(dirname "${BASH_SOURCE[0]}")
note=$1/.packages
log=$1/packages.log
command -v dpkg-query > /dev/null || exit 0 # no Debian: CMake says what it doesn't find

state() { stat -c '%i %Y %s' /var/lib/dpkg/status "$here/packages.txt"; }
[[ -f $note && $(< "$note") == "$(state)" ]] && exit 0

mapfile -t wanted < <(sed -E 's/ *#.*//; /^$/d' "$here/packages.txt")
present=$(dpkg-query -W -f '${Package} ${db:Status-Status}\n' "${wanted[@]}" 2> /dev/null |
  sed -n 's/ installed$//p' || true)
mapfile -t missing < <(comm -23 <(printf '%s\n' "${wanted[@]}" | sort) <(sort -u <<< "$present"))

if ((${#missing[@]})); then
  as_root=()
  if ((EUID != 0)); then
    if ! command -v sudo > /dev/null; then
      echo "airclay: these packages are missing, and neither root nor sudo is at hand: ${missing[*]}" >&2
      exit 1
    fi
    as_root=(sudo)
  fi
  echo "airclay: installing what is missing: ${missing[*]}" >&2
  apt() { "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q -o DPkg::Lock::Timeout=600 "$@"; }
  if ! { apt update && apt install -y --no-install-recommends "${missing[@]}"; } > "$log" 2>&1 < /dev/null; then
    tail -n 20 "$log" >&2
    echo "airclay: the packages could not be installed; the whole log is $log" >&2
    exit 1
  fi
fi
state > "$note"
