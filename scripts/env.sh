# shellcheck shell=bash
# Sourced by the scripts: the project's folder as working directory, cargo on the path, the toolchain that
# scripts/setup-wasm chose, and how a script speaks.

cd "$(dirname "${BASH_SOURCE[0]}")/.." || exit

# rustup's installer changes the path of the next login only.
command -v cargo >/dev/null || PATH=$PATH:${CARGO_HOME:-$HOME/.cargo}/bin

WASM_TOOLCHAIN_DIR=${WASM_TOOLCHAIN_DIR:-$HOME/.cache/wasm-toolchain}
# shellcheck source=/dev/null
if [ -f "$WASM_TOOLCHAIN_DIR/env.sh" ]; then . "$WASM_TOOLCHAIN_DIR/env.sh"; fi

say() { printf '[%s] %s\n' "${0##*/}" "$*"; }
die() {
  say "ERROR: $*" >&2
  exit 1
}

# Whether the last build was a quick one (scripts/build --quick), which is for tests only.
is_quick_build() { [ -f www/pkg/quick-build ]; }
refuse_quick_build() {
  if is_quick_build; then die "www/pkg is a quick build, for tests only (scripts/test makes one); run scripts/build first"; fi
}

may_use_apt() {
  command -v apt-get >/dev/null && { [ "$(id -u)" = 0 ] || sudo -n true 2>/dev/null; }
}

apt_get() {
  local as_root=()
  [ "$(id -u)" = 0 ] || as_root=(sudo -n)
  say "apt-get $*"
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get "$@"
}
