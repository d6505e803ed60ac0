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
mkdocs build --strict --clean -d "$out"
echo "build_site.sh: open $out/index.html"
