#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Installs the missing packages of packages.txt. Usage: setup.sh FOLDER. A file in FOLDER records the state of the
# package database once nothing is missing, so that the next call returns at once.
set -euo pipefail

here=$(dirname "${BASH_SOURCE[0]}")
state_file=$1/.packages
log=$1/packages.log
command -v dpkg-query > /dev/null || exit 0 # not Debian: CMake reports what it does not find

state() { stat -c '%i %Y %s' /var/lib/dpkg/status "$here/packages.txt"; }
[[ -f $state_file && $(< "$state_file") == "$(state)" ]] && exit 0

mapfile -t required < <(sed -E 's/ *#.*//; /^$/d' "$here/packages.txt")
present=$(dpkg-query -W -f '${Package} ${db:Status-Status}\n' "${required[@]}" 2> /dev/null |
  sed -n 's/ installed$//p' || true)
mapfile -t missing < <(comm -23 <(printf '%s\n' "${required[@]}" | sort) <(sort -u <<< "$present"))

if ((${#missing[@]})); then
  as_root=()
  if ((EUID != 0)); then
    if ! command -v sudo > /dev/null; then
      echo "airclay: these packages are missing, and installing them needs root or sudo: ${missing[*]}" >&2
      exit 1
    fi
    as_root=(sudo)
  fi
  echo "airclay: installing missing packages: ${missing[*]}" >&2
  apt() { "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q -o DPkg::Lock::Timeout=600 "$@"; }
  if ! { apt update && apt install -y --no-install-recommends "${missing[@]}"; } > "$log" 2>&1 < /dev/null; then
    tail -n 20 "$log" >&2
    echo "airclay: cannot install the packages; the complete log is $log" >&2
    exit 1
  fi
fi
state > "$state_file"
