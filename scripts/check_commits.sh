#!/usr/bin/env bash
# Fails when one of the last commits has a subject that CONTRIBUTING.md does not allow:
# "area[, area]: what changed", 72 characters at most.
# Usage: check_commits.sh [COUNT]
set -euo pipefail
cd "$(dirname "$0")/.."
area='(kernels|ingest|recon4d|static3d|tools|player|tests|docs|build|ci|research)'
subject="^$area(, $area)*: [a-z]"
git rev-parse --git-dir >/dev/null 2>&1 || exit 0 # an archive of sources has no commits
bad=0
while read -r commit line; do
  [[ $line =~ $subject ]] && [ "${#line}" -le 72 ] && continue
  echo "$commit: not of the form 'area: what changed', or longer than 72 characters: $line" >&2
  bad=1
done < <(git log --no-merges --format='%h %s' -n "${1:-20}")
exit $bad
