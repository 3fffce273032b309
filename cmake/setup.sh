#!/usr/bin/env bash
# Installs what the build needs and the machine lacks: Debian packages (as root or through sudo) and the Python
# environment build/venv with the pinned tools of cmake/requirements.txt. Running it again costs a second.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
venv=$root/build/venv

packages=(g++ cmake ninja-build make libeigen3-dev libsundials-dev libgtest-dev libbenchmark-dev
          libyaml-cpp-dev libmsgpack-cxx-dev libcli11-dev libspdlog-dev libglib2.0-0
          python3-venv python3-dev libxml2-utils libtbb12 valgrind ca-certificates
          iproute2 can-utils tshark user-mode-linux liblcm-dev)

missing_packages() {
  local package
  for package in "${packages[@]}"; do
    dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || echo "$package"
  done
}

install_packages() {
  mapfile -t missing < <(missing_packages)
  [ ${#missing[@]} -eq 0 ] && return
  local as_root=()
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || { echo "setup: as root, run: apt-get install ${missing[*]}" >&2; exit 1; }
    as_root=(sudo)
  fi
  echo "setup: installing ${missing[*]}"
  "${as_root[@]}" apt-get update -qq >/dev/null
  local log
  log=$("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends \
    "${missing[@]}" 2>&1) || { echo "$log" >&2; exit 1; }
}

install_venv() {
  local lock=$root/cmake/requirements.txt
  cmp -s "$lock" "$venv/.installed" && return
  echo "setup: Python tools into build/venv"
  [ -x "$venv/bin/python" ] || /usr/bin/python3 -m venv "$venv"
  "$venv/bin/pip" install -q --disable-pip-version-check -r "$lock"
  cp "$lock" "$venv/.installed"
}

# The package runs from the build tree: build/python holds the module and links to host/python.
install_command() {
  local site
  site=$("$venv/bin/python" -c 'import sysconfig; print(sysconfig.get_path("purelib"))')
  echo "$root/build/python" >"$site/glenoid.pth"
  printf '#!%s\nimport sys\n\nfrom glenoid.cli import main\n\nsys.exit(main())\n' "$venv/bin/python" >"$venv/bin/glenoid"
  chmod +x "$venv/bin/glenoid"
}

command -v dpkg-query >/dev/null && install_packages
mkdir -p "$root/build"
install_venv
install_command
