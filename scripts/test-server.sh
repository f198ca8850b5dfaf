#!/bin/sh
# PostgreSQL's programs, which only the tests need: they start a server of their own in a temporary folder. Installed
# where we are root, named where we are not (those tests are skipped then). No server is set up for the machine.
set -u

for programs in /usr/lib/postgresql/*/bin; do
  [ -x "$programs/initdb" ] && exit 0
done
command -v initdb >/dev/null 2>&1 && exit 0

if [ "$(id -u)" != 0 ] || ! command -v apt-get >/dev/null 2>&1; then
  echo "Tests of studies on a server are skipped: they need PostgreSQL (sudo apt-get install postgresql)." >&2
  exit 0
fi
echo "Installing postgresql for the tests"
settings=/etc/postgresql-common/createcluster.d
mkdir -p "$settings"
echo "create_main_cluster = false" >"$settings/concord-tests.conf"
apt-get update -qq
DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends postgresql >/dev/null ||
  echo "PostgreSQL could not be installed; tests of studies on a server are skipped." >&2
rm -f "$settings/concord-tests.conf"
exit 0
