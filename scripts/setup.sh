#!/bin/sh
# Make the virtual environment in the checkout and install Concord into it, with exact versions.
set -eu
venv=${1:-.venv}

python=""
for candidate in ${PYTHON:-} python3 python3.13 python3.12 python3.11 python3.14; do
  if command -v "$candidate" >/dev/null 2>&1 &&
     "$candidate" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then
    python=$candidate
    break
  fi
done
if [ -z "$python" ]; then
  echo "Concord needs Python 3.11 or newer; install it with: sudo apt-get install python3 python3-venv" >&2
  exit 2
fi

if ! "$python" -c 'import ensurepip, venv' 2>/dev/null; then
  version=$("$python" -c 'import sys; print(f"python{sys.version_info[0]}.{sys.version_info[1]}-venv")')
  if [ "$(id -u)" = 0 ]; then
    echo "Installing $version ..."
    apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$version" >/dev/null
  else
    echo "Concord needs the Debian package $version; run: sudo apt-get install $version" >&2
    exit 2
  fi
fi

[ -x "$venv/bin/python" ] || "$python" -m venv "$venv"
echo "Installing Concord and its libraries into $venv (a few minutes the first time) ..."
"$venv/bin/python" -m pip install --quiet --disable-pip-version-check --constraint constraints.txt \
  --editable '.[gui,parquet,test,lint]'
echo "Compiling the fast loops ..."
"$venv/bin/python" -m engine.warm
