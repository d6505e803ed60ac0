#!/usr/bin/env bash
# Builds the documentation site from docs/ and mkdocs.yml. Warnings are errors.
# Usage: build_site.sh [OUT]     (default: build/site)
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1:-build/site}

if ! command -v mkdocs >/dev/null; then
  echo "build_site.sh: mkdocs is not installed; run" \
    "apt-get install --no-install-recommends mkdocs mkdocs-material" >&2
  exit 2
fi
# Debian's module, whichever python3 comes first on the PATH
python=$(head -n 1 "$(command -v mkdocs)" | cut -c 3-)
if ! $python -c 'import sys, mkdocs.utils as u; sys.exit("material" not in u.get_theme_names())'; then
  echo "build_site.sh: the material theme of mkdocs is not installed; run" \
    "apt-get install --no-install-recommends mkdocs-material" >&2
  exit 2
fi
mkdocs build --strict --clean -d "$out"
echo "build_site.sh: open $out/index.html"
